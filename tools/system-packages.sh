#!/bin/sh
# Installs the Debian packages that a task needs, if any is missing: system-packages.sh build [test] [firmware]
# Where it may not (neither root nor password-less sudo, or no apt) it names them in one line and stops.
set -eu
wanted=""
for task in "$@"; do
  case "$task" in
    build) wanted="$wanted g++ libeigen3-dev liborocos-kdl-dev liburdfdom-dev python3-dev python3-venv" ;;
    test) wanted="$wanted libgtest-dev" ;;
    firmware) wanted="$wanted gcc-avr avr-libc libsimavr-dev libelf-dev" ;;
    *) echo "system-packages.sh: unknown task '$task' (build, test, firmware)" >&2; exit 2 ;;
  esac
done
missing=""
for package in $wanted; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing="$missing $package"
done
[ -n "$missing" ] || exit 0
if ! command -v apt-get >/dev/null; then
  echo "lfdcore needs a C++ compiler, Eigen 3.4, Orocos KDL, urdfdom, GoogleTest (for the tests), avr-gcc, avr-libc, simavr and libelf (for the firmware) and Python's headers and venv; this system has no apt-get: please install them by hand." >&2
  exit 0
fi
if [ "$(id -u)" = 0 ]; then root=""; elif sudo -n true 2>/dev/null; then root="sudo"; else
  echo "lfdcore needs these packages:$missing - please run: sudo apt-get install$missing" >&2
  exit 1
fi
echo "installing system packages:$missing"
$root apt-get -qq update >/dev/null
DEBIAN_FRONTEND=noninteractive $root apt-get -qq install -y --no-install-recommends $missing >/dev/null
