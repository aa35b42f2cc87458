"""A LIDAR on a real pty or TCP connection: its scans are those that it took, and whatever happens to it is a state."""

import gc
import itertools
import math
import os
import random
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from lfdcore.errors import DeviceError
from lfdcore.hardware import ScipLidar, TimedScan
from scip_device import CLOCK, URG_04LX, UTM_30LX, Distances, Model, PtyLink, ScipDevice, TcpLink

PATIENCE = 60.0
"""[s] that nothing here waits for unless it fails"""


def any_scan(model: Model) -> Callable[[int], Distances]:
    """Random distances and codes; the first one tells the number of the turn."""

    def scan(number: int) -> Distances:
        return [1000 + number % 1000, *any_ranges(model.beams - 1, model.dmax + 2, number % 40)]

    return scan


@cache
def any_ranges(count: int, bound: int, seed: int) -> Distances:
    """[mm], made once: the device must keep up."""
    random_ = random.Random(seed)
    return [random_.randrange(bound) for _ in range(count)]


def number(scan: TimedScan) -> int:
    """Of the turn, as any_scan tells it."""
    return round(float(scan.scan.ranges[0]) * 1000) - 1000


def ranges_of(distances: Distances, model: Model) -> NDArray[np.float32]:
    """By hand: codes and what lies below DMIN are NaN, what lies beyond DMAX is nothing, all else is in mm."""
    mm = np.array(distances)
    ranges = (mm / 1000).astype(np.float32)
    ranges[(mm < 20) | (mm < model.dmin)] = math.nan
    ranges[mm >= model.dmax] = math.inf
    if model is UTM_30LX:
        ranges[mm == 1] = math.inf
    return ranges


@pytest.fixture(params=["pty", "tcp"])
def link(request: pytest.FixtureRequest, tmp_path: Path) -> PtyLink | TcpLink:
    return PtyLink(tmp_path) if request.param == "pty" else TcpLink()


@pytest.fixture
def device(link: PtyLink | TcpLink) -> Iterator[ScipDevice]:
    with ScipDevice(link, any_scan(UTM_30LX)) as device:
        yield device


def scans(lidar: ScipLidar, count: int) -> list[TimedScan]:
    """The next ones; fails where none comes."""
    got: list[TimedScan] = []
    newest = lidar.newest()
    for _ in range(count):
        newest = lidar.wait_newer(newest.sequence if newest else 0, PATIENCE)
        assert newest is not None, lidar.fault()
        got.append(newest)
    return got


def wait_until(holds: Callable[[], bool]) -> None:
    """For what nothing but asking tells."""
    deadline = time.monotonic() + PATIENCE
    while not holds():
        assert time.monotonic() < deadline
        time.sleep(0.002)


def open_files() -> int:
    return len(os.listdir("/proc/self/fd"))


@pytest.fixture
def lidar(device: ScipDevice) -> Iterator[ScipLidar]:
    lidar = ScipLidar(device.address)
    yield lidar
    lidar.close()


def test_ranges_are_those_that_the_device_measured_bit_for_bit(device: ScipDevice, lidar: ScipLidar) -> None:
    for scan in scans(lidar, 30):
        expected = ranges_of(any_scan(UTM_30LX)(number(scan)), UTM_30LX)
        np.testing.assert_array_equal(np.asarray(scan.scan.ranges).view(np.uint32), expected.view(np.uint32))
    assert lidar.statistics().damaged == 0
    assert lidar.fault() == ""


def test_angles_run_counter_clockwise_around_the_front(lidar: ScipLidar) -> None:
    scan = scans(lidar, 1)[0].scan
    assert len(scan.ranges) == 1081
    assert scan.angles()[540] == 0
    assert scan.angle_min == -math.radians(135)
    assert scan.angle_increment == math.radians(0.25)
    assert (scan.range_max, lidar.scan_period(), lidar.model()) == (60, 0.025, "UTM-30LX")


def test_a_lidar_that_hangs_is_mirrored(device: ScipDevice) -> None:
    lidar = ScipLidar(device.address, upside_down=True)
    scan = scans(lidar, 1)[0].scan
    lidar.close()
    turn = round(float(scan.ranges[-1]) * 1000) - 1000
    expected = ranges_of(any_scan(UTM_30LX)(turn), UTM_30LX)
    np.testing.assert_array_equal(scan.ranges, expected[::-1])


def test_an_urg_on_a_slow_serial_port_is_found_at_its_own_rate(tmp_path: Path) -> None:
    with ScipDevice(PtyLink(tmp_path), any_scan(URG_04LX), URG_04LX, scip_1=True, baud=19200) as device:
        lidar = ScipLidar(device.address)
        for scan in scans(lidar, 3):
            expected = ranges_of(any_scan(URG_04LX)(number(scan)), URG_04LX)
            np.testing.assert_array_equal(scan.scan.ranges, expected)
        assert scan.scan.angle_min == pytest.approx((44 - 384) * 2 * math.pi / 1024)
        lidar.close()
        wait_until(lambda: device.heard[-1] == "QT")


@pytest.mark.parametrize(("rate", "start"), [(1.0, 0), (1.0001, CLOCK - 1500), (0.9999, 7_000_000)])
def test_stamps_say_when_the_turn_began_also_where_the_clock_begins_anew(
    link: PtyLink | TcpLink, rate: float, start: int
) -> None:
    errors = []
    with ScipDevice(link, any_scan(UTM_30LX), clock_rate=rate, clock_start=start) as device:
        lidar = ScipLidar(device.address)
        for scan in scans(lidar, 80):
            assert scan.stamp <= time.monotonic()
            errors.append(scan.stamp - device.taken[number(scan)])
        lidar.close()
    assert abs(float(np.median(errors))) < 0.02
    assert max(errors) - min(errors) < 0.01


@pytest.mark.parametrize("piece", [1, 7, 1000])
def test_bytes_may_come_in_any_pieces(link: PtyLink | TcpLink, piece: int) -> None:
    with ScipDevice(link, any_scan(URG_04LX), URG_04LX) as device:
        device.mangle = lambda reply: (reply[i : i + piece] for i in range(0, len(reply), piece))
        lidar = ScipLidar(device.address)
        for scan in scans(lidar, 5):
            np.testing.assert_array_equal(scan.scan.ranges, ranges_of(any_scan(URG_04LX)(number(scan)), URG_04LX))
        assert lidar.statistics().damaged == 0
        lidar.close()


def cut(reply: bytes) -> list[bytes]:
    return [reply[: len(reply) // 2]]


def wrong_sum(reply: bytes) -> list[bytes]:
    return [reply[:200] + bytes([reply[200] ^ 1]) + reply[201:]]


def garbage_before(reply: bytes) -> list[bytes]:
    return [b"\x00\xff\n\n@@@\n\n" + reply]


def without_end(reply: bytes) -> list[bytes]:
    return [reply[:-1]]


@pytest.mark.hazard("A scan was damaged on its way", "it is not used, and the next one is")
@pytest.mark.parametrize("damage", [cut, wrong_sum, garbage_before, without_end])
def test_damaged_replies_are_counted_and_never_become_scans(
    device: ScipDevice, lidar: ScipLidar, damage: Callable[[bytes], list[bytes]]
) -> None:
    turns = itertools.count()
    device.mangle = lambda reply: damage(reply) if next(turns) % 3 == 0 and len(reply) > 300 else [reply]
    for scan in scans(lidar, 30):
        np.testing.assert_array_equal(scan.scan.ranges, ranges_of(any_scan(UTM_30LX)(number(scan)), UTM_30LX))
    said = lidar.statistics()
    assert said.damaged >= 5
    assert said.lost >= (0 if damage is garbage_before else 5)


def test_random_damage_never_becomes_a_scan_with_other_ranges_unless_its_sum_is_right(
    device: ScipDevice, lidar: ScipLidar
) -> None:
    """One character of each scan is another: no such scan may come through, as a sum of 6 bits tells."""
    random_ = random.Random(3)

    def damaged(reply: bytes) -> Iterable[bytes]:
        if len(reply) < 300 or random_.random() < 0.3:
            return [reply]
        at = random_.randrange(30, len(reply) - 2)
        other = random_.choice([byte for byte in range(0x30, 0x70) if byte != reply[at]])
        return [reply[:at] + bytes([other]) + reply[at + 1 :]]

    device.mangle = damaged
    for scan in scans(lidar, 30):
        np.testing.assert_array_equal(scan.scan.ranges, ranges_of(any_scan(UTM_30LX)(number(scan)), UTM_30LX))


@pytest.mark.hazard("A scanner is lost while driving", "the last scan keeps its stamp, and it measures again by itself")
@pytest.mark.parametrize("loss", ["unplug", "reset", "silence"])
def test_a_lidar_that_was_lost_measures_again_when_it_is_back(device: ScipDevice, lidar: ScipLidar, loss: str) -> None:
    last = scans(lidar, 3)[-1]
    if loss == "unplug":
        device.unplug()
    elif loss == "reset":
        device.reset()
    else:
        device.silent = True
    wait_until(lambda: lidar.fault() != "")
    assert device.address in lidar.fault()
    stale = lidar.newest()
    assert stale is not None and stale.sequence >= last.sequence
    if loss == "unplug":
        wait_until(lambda: re.search("no such device|refuses the connection", lidar.fault()) is not None)
        device.replug()
    device.silent = False
    newer = lidar.wait_newer(stale.sequence, PATIENCE)
    assert newer is not None
    assert abs(newer.stamp - device.taken[number(newer)]) < 0.05
    wait_until(lambda: lidar.fault() == "")
    assert lidar.statistics().reconnects >= 1


def test_a_silent_lidar_is_noticed_after_a_second(device: ScipDevice, lidar: ScipLidar) -> None:
    scans(lidar, 3)
    device.silent = True
    wait_until(lambda: "no scan for more than 1 s" in lidar.fault())
    newest = lidar.newest()
    assert newest is not None
    assert time.monotonic() - newest.stamp > 1.0


def test_a_lidar_whose_clock_jumps_is_synchronised_anew(device: ScipDevice, lidar: ScipLidar) -> None:
    scans(lidar, 3)
    device.clock_start += 3_000_000
    wait_until(lambda: lidar.statistics().reconnects == 1)
    for scan in scans(lidar, 3):
        assert abs(scan.stamp - device.taken[number(scan)]) < 0.05


@pytest.mark.parametrize(
    ("command", "status", "meaning"),
    [
        (
            "BM",
            "01",
            "status 01: its laser is broken: switch it off and on, else repair it (it says: Sensor works well.)",
        ),
        ("MD", "10", "status 10: its laser is off"),
        ("MD", "55", "status 55: its laser or its motor is broken"),
        ("PP", "0I", "status 0I: its firmware is being updated"),
    ],
)
def test_what_the_device_refuses_is_said_in_words(device: ScipDevice, command: str, status: str, meaning: str) -> None:
    device.statuses[command] = status
    with pytest.raises(DeviceError, match=re.escape(f"{device.address}: does not do {command}")) as error:
        ScipLidar(device.address)
    assert meaning in str(error.value)


def test_a_laser_that_fails_while_measuring_is_a_fault_until_it_works(device: ScipDevice, lidar: ScipLidar) -> None:
    scans(lidar, 2)
    device.statuses["BM"] = "01"
    device.reset()
    wait_until(lambda: "its laser is broken" in lidar.fault())
    del device.statuses["BM"]
    scans(lidar, 2)
    wait_until(lambda: lidar.fault() == "")


def test_a_device_that_is_absent_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(DeviceError, match="there is no such device"):
        ScipLidar(str(tmp_path / "ttyACM0"))


def test_a_device_that_speaks_something_else_is_an_error(device: ScipDevice) -> None:
    device.mangle = lambda _: [b"$GPGGA,123519,4807.038,N*47\r\n"]
    with pytest.raises(DeviceError, match=r"no SCIP 2.0 device answers.*it says [0-9]+ bytes, but no answer"):
        ScipLidar(device.address)


def test_a_device_that_says_nothing_is_an_error(device: ScipDevice) -> None:
    device.silent = True
    with pytest.raises(DeviceError, match=r"no SCIP 2.0 device answers.*it says nothing.*check its power"):
        ScipLidar(device.address)


def test_all_rates_that_were_tried_are_named(tmp_path: Path) -> None:
    with (
        ScipDevice(PtyLink(tmp_path), any_scan(UTM_30LX), baud=1) as device,
        pytest.raises(DeviceError, match="at 9600, 115200, 19200, 57600, 500000 baud"),
    ):
        ScipLidar(device.address, baud=9600)


@pytest.mark.parametrize("address", ["host:0", "host:65536", "host:x", "host:"])
def test_a_port_that_cannot_be_is_an_error(address: str) -> None:
    with pytest.raises(ValueError, match="must be a number of 1 to 65535"):
        ScipLidar(address)


def test_two_programs_cannot_share_a_serial_port(tmp_path: Path) -> None:
    with ScipDevice(PtyLink(tmp_path), any_scan(UTM_30LX)) as device:
        lidar = ScipLidar(device.address)
        with pytest.raises(DeviceError, match="taken by another program"):
            ScipLidar(device.address)
        lidar.close()
        ScipLidar(device.address).close()


def test_a_device_that_still_measures_for_a_program_that_is_gone_is_taken_over(device: ScipDevice) -> None:
    first = ScipLidar(device.address)
    device.mangle = lambda reply: [] if reply.startswith(b"QT") else [reply]
    first.close()
    device.mangle = lambda reply: [reply]
    lidar = ScipLidar(device.address)
    scans(lidar, 2)
    lidar.close()


def test_a_device_that_floods_is_lost_and_closes_at_once(device: ScipDevice, lidar: ScipLidar) -> None:
    scans(lidar, 2)
    device.mangle = lambda _: itertools.repeat(b"\n\nMD0000108001000\n99b\nxxxx\n\n" * 100, 400)
    wait_until(lambda: lidar.fault() != "" and lidar.statistics().damaged > 10_000)
    begin = time.monotonic()
    lidar.close()
    assert time.monotonic() - begin < 5
    device.mangle = lambda reply: [reply]


def test_closing_ends_the_thread_whatever_it_does(device: ScipDevice) -> None:
    random_ = random.Random(5)
    for loss in (device.unplug, device.reset, lambda: setattr(device, "silent", True), lambda: None) * 3:
        lidar = ScipLidar(device.address)
        scans(lidar, 1)
        loss()
        time.sleep(random_.uniform(0, 0.5))  # somewhere on its way back
        begin = time.monotonic()
        lidar.close()
        lidar.close()
        assert time.monotonic() - begin < 5
        assert lidar.newest() is not None
        assert "closed" in lidar.fault()
        device.silent = False
        if loss == device.unplug:
            device.replug()


def test_a_thousand_lidars_leave_no_file_and_no_thread(tmp_path: Path) -> None:
    with ScipDevice(PtyLink(tmp_path), lambda _: [1000] * UTM_30LX.beams) as device:
        ScipLidar(device.address).close()
        gc.collect()
        files, threads = open_files(), len(os.listdir("/proc/self/task"))
        for turn in range(1000):
            lidar = ScipLidar(device.address)
            if turn % 2:
                lidar.close()
            del lidar
        assert (open_files(), len(os.listdir("/proc/self/task"))) == (files, threads)


def test_other_threads_run_on_while_one_waits(device: ScipDevice, lidar: ScipLidar) -> None:
    device.silent = True
    turns = 0
    done = threading.Event()

    def wait() -> None:
        lidar.wait_newer(10**9, 0.5)
        done.set()

    waiting = threading.Thread(target=wait)
    waiting.start()
    while not done.is_set():
        turns += 1
        time.sleep(0.001)
    waiting.join()
    assert turns > 20


def test_a_wait_can_be_interrupted(device: ScipDevice, lidar: ScipLidar) -> None:
    device.silent = True
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it
    timer = threading.Timer(0.2, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        lidar.wait_newer(10**9, PATIENCE)
    timer.join()
    signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize("patience", [-1.0, math.nan])
def test_a_patience_that_cannot_be_is_an_error(lidar: ScipLidar, patience: float) -> None:
    with pytest.raises(ValueError, match="patience is"):
        lidar.wait_newer(10**9, patience)


def test_a_status_of_any_bytes_is_said_in_words_that_can_be_shown(device: ScipDevice) -> None:
    device.statuses["MD"] = "~\x7f"
    with pytest.raises(DeviceError, match=r"does not do MD.*: no answer"):
        ScipLidar(device.address)
    device.statuses["MD"] = "~~"
    with pytest.raises(DeviceError, match=r"status ~~: a status that SCIP 2.0 does not have"):
        ScipLidar(device.address)


def test_a_program_may_end_without_closing_it(device: ScipDevice) -> None:
    script = "import sys; from lfdcore.hardware import ScipLidar; lidar = ScipLidar(sys.argv[1]); print(lidar.model())"
    command = [sys.executable, "-c", script, device.address]
    ended = subprocess.run(command, check=False, capture_output=True, text=True, timeout=PATIENCE)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "UTM-30LX\n", "")


def test_a_program_that_was_stopped_for_a_while_goes_on_with_fresh_scans(link: PtyLink | TcpLink) -> None:
    """All that came in meanwhile is old, and says so; the device that could not go on sending is not lost."""
    script = (
        "import sys, time; from lfdcore.hardware import ScipLidar; lidar = ScipLidar(sys.argv[1])\n"
        "sequence = lidar.wait_newer(0, 30).sequence\n"
        "print('up', flush=True)\n"
        "sys.stdin.readline()\n"
        "while True:\n"
        "    newest = lidar.wait_newer(sequence, 30); sequence = newest.sequence\n"
        "    assert newest.stamp <= time.monotonic()\n"
        "    if time.monotonic() - newest.stamp < 0.2: break\n"
    )
    with ScipDevice(link, any_scan(UTM_30LX)) as device:
        command = [sys.executable, "-c", script, device.address]
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdin is not None and process.stdout is not None
            assert process.stdout.readline() == "up\n"
            process.send_signal(signal.SIGSTOP)
            time.sleep(1.5)
            process.send_signal(signal.SIGCONT)
            process.stdin.write("go\n")
            process.stdin.flush()
            assert process.wait(PATIENCE) == 0


def test_a_late_answer_about_its_time_is_not_taken_for_the_next_one(device: ScipDevice) -> None:
    held: list[bytes] = []
    given: list[bytes] = []

    def hold_back(reply: bytes) -> list[bytes]:
        if reply.startswith(b"TM1") and not held:
            held.append(reply)
            return []
        if reply.startswith(b"TM2") and held and not given:
            given.append(held[0])
            return [held[0], reply]
        return [reply]

    device.mangle = hold_back
    lidar = ScipLidar(device.address)
    for scan in scans(lidar, 5):
        assert abs(scan.stamp - device.taken[number(scan)]) < 0.05
    lidar.close()
    assert given
