"""map_server maps: flipped once, thresholds as map_server has them, refusals that name the key."""

import os
import struct
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from lfdcore.datasets import read_map, write_map
from lfdcore.errors import DataError
from lfdcore.geometry import Pose2
from lfdcore.grid import OccupancyGrid

GOOD = {
    "image": "map.pgm",
    "resolution": 0.05,
    "origin": [-1.0, 2.0, 0.0],
    "negate": 0,
    "occupied_thresh": 0.65,
    "free_thresh": 0.196,
}
PIXELS = np.array([[0, 254, 205], [254, 254, 0]], np.uint8)  # row 0 is the top


def write(folder: Path, pixels: np.ndarray | bytes = PIXELS, suffix: str = ".pgm", **changes: object) -> Path:
    described = {**GOOD, "image": f"map{suffix}", **changes}
    data = pixels if isinstance(pixels, bytes) else cv2.imencode(suffix, pixels)[1].tobytes()
    (folder / f"map{suffix}").write_bytes(data)
    path = folder / "map.yaml"
    path.write_text(yaml.safe_dump({key: value for key, value in described.items() if value is not None}))
    return path


def bomb() -> bytes:
    """A PNG whose head says 60000 x 60000 pixels."""
    small = cv2.imencode(".png", PIXELS)[1].tobytes()
    return small[:16] + struct.pack(">II", 60_000, 60_000) + small[24:]


@pytest.mark.parametrize("suffix", [".pgm", ".png"])
def test_row_0_of_the_grid_is_the_bottom_row_of_the_image(tmp_path: Path, suffix: str) -> None:
    grid = read_map(write(tmp_path, suffix=suffix))
    np.testing.assert_array_equal(grid.data, [[0, 0, 100], [100, 0, -1]])
    assert (grid.resolution, grid.origin) == (0.05, (-1.0, 2.0))
    assert grid.cell_at(-0.99, 2.01) == (0, 0)


@pytest.mark.parametrize("maxval", [100, 255, 1000, 65535])
@pytest.mark.parametrize("kind", [b"P2", b"P5"])
def test_a_grey_is_a_share_of_its_files_own_white(tmp_path: Path, kind: bytes, maxval: int) -> None:
    levels = np.array([[0, maxval, round(0.5 * maxval)]])
    text = " ".join(map(str, levels[0])).encode() + b"\n"
    raw = text if kind == b"P2" else levels.astype(">u2" if maxval > 255 else "u1").tobytes()
    head = kind + b"\n# made by hand\n3 1\n" + str(maxval).encode() + b"\n"
    np.testing.assert_array_equal(read_map(write(tmp_path, head + raw)).data, [[100, 0, -1]])


@pytest.mark.parametrize("under", [0, 255])
def test_what_is_transparent_is_unknown(tmp_path: Path, under: int) -> None:
    image = np.full((2, 3, 4), 255, np.uint8)
    image[0] = [under, under, under, 0]
    np.testing.assert_array_equal(read_map(write(tmp_path, image, ".png")).data, [[0, 0, 0], [-1, -1, -1]])


def test_a_colour_counts_by_the_mean_of_its_channels(tmp_path: Path) -> None:
    image = np.array([[[255, 0, 0], [255, 255, 255], [0, 0, 0]]], np.uint8)  # a blue pixel is two thirds black
    cells = read_map(write(tmp_path, image, ".png", occupied_thresh=0.66)).data
    np.testing.assert_array_equal(cells, [[100, 0, 100]])


def test_mode_scale_tells_shades_and_mode_raw_what_the_image_says(tmp_path: Path) -> None:
    greys = np.array([[0, 254, 128, 100]], np.uint8)
    scaled = read_map(write(tmp_path, greys, mode="scale")).data[0]
    assert scaled.tolist() == [
        100,
        0,
        round((127 / 255 - 0.196) / (0.65 - 0.196) * 100),
        round((155 / 255 - 0.196) / 0.454 * 100),
    ]
    assert read_map(write(tmp_path, greys, mode="raw")).data[0].tolist() == [0, -1, -1, 100]


@settings(max_examples=40, deadline=None)
@given(st.floats(-4, 4), st.floats(-3, 3), st.floats(-3, 3))
def test_a_turned_origin_is_turned_back(
    tmp_path_factory: pytest.TempPathFactory, yaw: float, x: float, y: float
) -> None:
    folder = tmp_path_factory.mktemp("turned")
    pixels = np.full((20, 30), 205, np.uint8)
    pixels[4:9, 6:14] = 0
    pixels[12:18, 15:28] = 254
    straight = read_map(write(folder, pixels, origin=[0.0, 0.0, 0.0]))
    turned = read_map(write(folder, pixels, origin=[x, y, yaw]))
    corner = Pose2(x, y, yaw)
    for row, column in ((8, 10), (13, 9), (4, 20), (5, 25), (2, 2)):  # well inside of each area
        place = corner.transform(np.array([[(column + 0.5) * 0.05, (row + 0.5) * 0.05]]))[0]
        cell = turned.cell_at(*map(float, place))
        assert cell is not None
        assert turned.data[cell[1], cell[0]] == straight.data[row, column]


def test_numbers_are_read_as_map_server_reads_them(tmp_path: Path) -> None:
    path = write(tmp_path)
    path.write_text(path.read_text().replace("resolution: 0.05", "resolution: 5e-2"))
    assert read_map(path).resolution == 0.05


def test_a_negated_image_means_white_is_occupied(tmp_path: Path) -> None:
    np.testing.assert_array_equal(
        read_map(write(tmp_path, 255 - PIXELS, negate=1)).data, read_map(write(tmp_path)).data
    )


def test_thresholds_part_the_greys_as_map_server_does(tmp_path: Path) -> None:
    greys = np.arange(256, dtype=np.uint8)[None]
    cells = read_map(write(tmp_path, greys, occupied_thresh=0.5, free_thresh=0.25)).data[0]
    for grey, cell in enumerate(cells):
        black = (255 - grey) / 255
        assert cell == (100 if black > 0.5 else 0 if black < 0.25 else -1)


@settings(max_examples=30, deadline=None)
@given(
    cells=st.integers(1, 9).flatmap(
        lambda width: st.lists(
            st.lists(st.sampled_from([0, 100, -1]), min_size=width, max_size=width), min_size=1, max_size=9
        )
    ),
    resolution=st.floats(1e-3, 1),
    x=st.floats(-1e4, 1e4),
)
def test_a_map_that_is_written_and_read_is_the_same(
    tmp_path_factory: pytest.TempPathFactory, cells: list[list[int]], resolution: float, x: float
) -> None:
    grid = OccupancyGrid(np.array(cells, np.int8), resolution, (x, -x))
    path = tmp_path_factory.mktemp("map") / "round.yaml"
    write_map(grid, path)
    again = read_map(path)
    np.testing.assert_array_equal(again.data, grid.data)
    assert (again.resolution, again.origin) == (grid.resolution, grid.origin)


def test_shares_between_free_and_occupied_are_written_as_map_saver_does(tmp_path: Path) -> None:
    write_map(OccupancyGrid(np.array([[0, 19, 20, 64, 65, 100, -1]], np.int8), 0.1), tmp_path / "grey.yaml")
    np.testing.assert_array_equal(read_map(tmp_path / "grey.yaml").data, [[0, 0, -1, -1, 100, 100, -1]])
    with pytest.raises(ValueError, match=r"must end in \.yaml"):
        write_map(OccupancyGrid(np.zeros((1, 1), np.int8), 0.1), tmp_path / "grey.pgm")


@pytest.mark.parametrize("key", ["image", "resolution", "origin", "occupied_thresh", "free_thresh"])
def test_a_missing_key_is_named(tmp_path: Path, key: str) -> None:
    with pytest.raises(DataError, match=rf"map\.yaml: key {key} is missing"):
        read_map(write(tmp_path, **{key: None}))


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"resolution": 0}, "resolution is 0.0 m, must be between 0.001 and 1 m"),
        ({"resolution": "fine"}, "resolution is 'fine', must be a finite number"),
        ({"resolution": True}, "resolution is True"),
        ({"resolution": float("nan")}, "resolution is nan"),
        ({"origin": [0, 0]}, r"origin is \[0, 0\], must be \[x, y, yaw\]"),
        ({"origin": [0, "a", 0]}, "origin is 'a'"),
        ({"negate": 2}, "negate is 2, must be 0 or 1"),
        ({"mode": "shades"}, "mode is 'shades', must be one of trinary, scale, raw"),
        ({"free_thresh": 0.7}, "free_thresh is 0.7, occupied_thresh 0.65"),
        ({"occupied_thresh": 1.5}, "occupied_thresh 1.5"),
        ({"image": 3}, "image is 3, must be the name of a file"),
        ({"image": "other.pgm"}, r"other\.pgm cannot be read"),
        ({"image": "."}, "cannot be read"),
        ({"pixels": b""}, "is cut or no image"),
        ({"pixels": b"P5\n100 100\n255\n" + bytes(50)}, "is cut or no image"),
        ({"pixels": b"P5\n99999 99999\n255\n" + bytes(50)}, "has 9999800001 cells"),
        ({"pixels": bomb(), "suffix": ".png"}, "has 3600000000 cells"),
    ],
)
def test_a_broken_map_is_refused_with_the_key_and_the_value(tmp_path: Path, changes: dict, reason: str) -> None:
    with pytest.raises(DataError, match=reason) as caught:
        read_map(write(tmp_path, **changes))
    assert "map.yaml" in str(caught.value)


@pytest.mark.parametrize("text", ["", "a: [", "- 1\n- 2\n", "\x00", "{" * 1500])
def test_a_yaml_that_is_none_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "map.yaml"
    path.write_text(text)
    with pytest.raises(DataError, match=r"map\.yaml"):
        read_map(path)
    with pytest.raises(FileNotFoundError):
        read_map(tmp_path / "none.yaml")


@settings(max_examples=100, deadline=None)
@given(st.data())
def test_a_garbled_map_is_read_or_refused_but_never_crashes(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    path = write(tmp_path_factory.mktemp("garbled"))
    for file in (path, path.with_suffix(".pgm")):
        content = bytearray(file.read_bytes())
        for _ in range(data.draw(st.integers(0, 3))):
            content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
        file.write_bytes(bytes(content))
    try:
        read_map(path)
    except DataError as error:
        assert "map.yaml" in str(error)


@pytest.mark.realdata
@pytest.mark.parametrize(
    ("name", "size", "resolution"),
    [
        ("aws_small_house", (500, 500), 0.05),
        ("bitbots_brsu-c069", (576, 544), 0.05),
        ("nav2_depot", (604, 307), 0.05),
        ("willow_full", (540, 587), 0.1),
    ],
)
def test_real_maps_are_read_and_survive_being_written(
    data_folder: Path, tmp_path: Path, name: str, size: tuple[int, int], resolution: float
) -> None:
    grid = read_map(data_folder / "maps" / f"{name}.yaml")
    assert (grid.width, grid.height) == size
    assert grid.resolution == resolution
    assert 0 < grid.occupied_mask().sum() < 0.1 * grid.data.size
    assert (grid.data == 0).sum() > 0.1 * grid.data.size
    write_map(grid, tmp_path / "again.yaml")
    np.testing.assert_array_equal(read_map(tmp_path / "again.yaml").data, grid.data)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"resolution": 100.0}, "resolution is 100.0 m, must be between 0.001 and 1 m"),
        ({"resolution": 1e-300}, "resolution is 1e-300 m"),
        ({"origin": [1e300, 0, 0]}, r"origin is \(1e\+300, 0\) m, must lie within 1e\+06 m"),
    ],
)
def test_a_map_on_an_absurd_scale_is_refused(tmp_path: Path, changes: dict, reason: str) -> None:
    with pytest.raises(DataError, match=reason):
        read_map(write(tmp_path, **changes))


def test_a_map_of_too_many_cells_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("lfdcore.datasets.map_image.MOST_CELLS", 5)
    with pytest.raises(DataError, match=r"has \d+ cells, must have at most 5"):
        read_map(write(tmp_path))


def test_a_pipe_in_place_of_a_map_is_refused_instead_of_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.yaml")
    with pytest.raises(DataError, match="no regular file"):
        read_map(tmp_path / "pipe.yaml")


def encoded(suffix: str) -> bytes:
    picture = np.random.default_rng(0).integers(0, 255, (60, 80), np.uint8)
    return bytes(cv2.imencode(suffix, picture)[1].tobytes())


@pytest.mark.parametrize("suffix", [".png", ".pgm", ".bmp", ".tiff", ".webp"])
@pytest.mark.parametrize("share", [0.02, 0.5])
def test_a_decoders_own_noise_about_a_broken_image_reaches_nobody(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], suffix: str, share: float
) -> None:
    whole = encoded(suffix)
    with pytest.raises(DataError, match="is cut or no image"):
        read_map(write(tmp_path, pixels=whole[: int(share * len(whole))]))
    assert capfd.readouterr() == ("", "")


def test_an_image_that_is_decoded_with_complaints_is_read_with_a_warning(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    jpeg = bytearray(encoded(".jpg"))
    jpeg[len(jpeg) // 2 : len(jpeg) // 2 + 40] = bytes(range(40, 80))
    with pytest.warns(UserWarning, match=r"may be damaged: Corrupt JPEG data"):
        assert read_map(write(tmp_path, pixels=bytes(jpeg))).data.shape == (60, 80)
    assert capfd.readouterr().err == ""
