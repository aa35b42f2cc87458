"""Prints the packages of an extra of pyproject.toml, for where lfdcore itself is not to be installed.

python tools/extra.py ros2
"""

import sys
import tomllib

from made_part import ROOT

if __name__ == "__main__":
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    print(*project["optional-dependencies"][sys.argv[1]])
