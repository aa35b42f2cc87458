"""One door for every format: opened by what a file holds, and honest about what it cannot open."""

import gzip
import shutil
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lfdcore.datasets import DriveLog, open_log
from lfdcore.errors import DataError
from lfdcore.geometry import Pose2


@pytest.mark.realdata
@pytest.mark.parametrize("name", ["fhw-corrected.log.gz", "sena-wheelchair-one-loop.rawlog"])
def test_a_log_opens_whatever_its_name_and_keeps_through_our_own_file(
    data_folder: Path, tmp_path: Path, name: str
) -> None:
    shutil.copyfile(data_folder / "logs" / name, tmp_path / "renamed")
    log = open_log(tmp_path / "renamed")
    log.save(tmp_path / "kept.mcap")
    kept = open_log(tmp_path / "kept.mcap")
    assert (kept.ranges == log.ranges).all()
    assert (kept.twist == log.twist).all()
    assert abs(kept.scan_stamp - log.scan_stamp).max() < 1e-9
    assert kept.metadata == log.metadata


def test_a_drive_log_opens_by_its_content(small_file: Path, small_log: DriveLog) -> None:
    moved = small_file.rename(small_file.with_suffix(".dat"))
    assert open_log(str(moved)).name == small_log.name


def test_options_reach_the_reader(tmp_path: Path) -> None:
    path = tmp_path / "drive.log.gz"
    path.write_bytes(gzip.compress(b"FLASER 180 " + b"1 " * 180 + b"0 0 0 0 0 0 1.5 host 1.5\n"))
    assert open_log(path, T_base_laser=Pose2(1, 0, 0)).T_base_laser == Pose2(1, 0, 0)


@pytest.mark.parametrize("content", [b"", b"hello\n", b"\x1f\x8b\x08garbled", gzip.compress(b"1 2 3\n", mtime=0)])
def test_what_is_of_no_known_format_is_refused_with_the_known_ones(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "what"
    path.write_bytes(content)
    with pytest.raises(DataError, match=r"CARMEN logs|gzip stream is cut"):
        open_log(path)


def test_a_folder_that_is_no_bag_and_a_file_that_is_none_are_distinguished(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"a folder without metadata\.yaml"):
        open_log(tmp_path)
    with pytest.raises(FileNotFoundError):
        open_log(tmp_path / "none.mcap")


HEADS = [b"", b"\x89MCAP0\r\n", b"#ROSBAG V2.0\n", b"SQLite format 3\0", b"\x8dCSensoryFrame", b"FLASER ", b"\x1f\x8b"]


@settings(max_examples=200, deadline=None)
@given(
    head=st.sampled_from(HEADS), rest=st.binary(max_size=200), suffix=st.sampled_from([".mcap", ".bag", ".log", ".db3"])
)
def test_any_bytes_under_any_name_are_a_data_error(
    tmp_path_factory: pytest.TempPathFactory, head: bytes, rest: bytes, suffix: str
) -> None:
    path = tmp_path_factory.mktemp("any") / f"file{suffix}"
    path.write_bytes(head + rest)
    with pytest.raises(DataError, match="file"):
        open_log(path)
