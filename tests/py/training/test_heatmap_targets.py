"""Sec. 4.3: training pairs of the sensor heatmap."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatmap_drives import around_the_corner, corridor_log
from lfdcore.datasets import open_log
from lfdcore.datasets.drive_log import DriveLog
from lfdcore.errors import DataError
from lfdcore.training.parts.heatmap_targets import STEP, HeatmapTargetConfig, draw_target, heatmap_pairs

ALL_FREE = np.ones((100, 100), bool)
BARE = HeatmapTargetConfig(sigma=0.0, path_radius=0.0, end_radius=0.0)


def line(*corners):
    """Points STEP apart along a polyline [m]."""
    parts = []
    for a, b in pairwise(corners):
        n = max(1, round(math.dist(a, b) / STEP))
        parts.append(np.array(a) + np.linspace(0, 1, n, endpoint=False)[:, None] * (np.array(b) - a))
    return np.vstack([*parts, [corners[-1]]])


def cell(point):
    return tuple(math.floor((v + 2.5) / 0.05) for v in (point[1], point[0]))


def blurred(image, sigma):
    """Gaussian with zeros around, pixel by pixel."""
    reach = 12
    kernel = np.exp(-((np.arange(-reach, reach + 1) * 0.05) ** 2) / (2 * sigma**2))
    kernel /= kernel.sum()
    rows = np.apply_along_axis(lambda row: np.convolve(row, kernel, "same"), 1, image)
    return np.apply_along_axis(lambda row: np.convolve(row, kernel, "same"), 0, rows)


def drawn_by_hand(free, paths, config):  # noqa: PLR0912
    """The same from the definition: every cell asks for the nearest path cell and the nearest end."""
    path_cells, end_cells = set(), set()
    for path in paths:
        portions, current = [], []
        for point in path:
            iy, ix = cell(point)
            if 0 <= iy < 100 and 0 <= ix < 100 and free[iy, ix]:
                current.append(point)
            elif current:
                portions.append(current)
                current = []
        for portion in [*portions, current]:
            nearest, away = 0, False
            for k, point in enumerate(portion):
                if math.hypot(*point) >= math.hypot(*portion[nearest]) + config.shortest:
                    away = True
                    break
                if math.hypot(*point) < math.hypot(*portion[nearest]):
                    nearest = k
            if away:
                path_cells |= {cell(p) for p in portion[nearest:]}
                end_cells.add(cell(portion[-1]))
    image = np.zeros((100, 100))
    for radius, value, cells in (
        (config.path_radius, config.path_value, path_cells),
        (config.end_radius, config.end_value, end_cells),
    ):
        for y in range(100):
            for x in range(100):
                if any(math.hypot(y - cy, x - cx) * 0.05 <= radius + 1e-9 for cy, cx in cells):
                    image[y, x] = value
    image = blurred(image, config.sigma) if config.sigma else image
    return image / image.max() if image.max() > 0 else image


def joined(paths):
    return np.vstack(paths), np.concatenate([np.full(len(p), k) for k, p in enumerate(paths)])


@pytest.mark.parametrize("config", [BARE, HeatmapTargetConfig(), HeatmapTargetConfig(end_radius=0.3, sigma=0.15)])
def test_the_target_is_the_one_drawn_by_hand(config):
    free = ALL_FREE.copy()
    free[60:80, 70:75] = False  # a wall that hides part of the second path
    free[:, :40] = False
    paths = [
        line((0.3, 0.02), (1.5, 0.1), (2.2, 1.9)),
        line((0.7, 0.6), (2.6, 0.8)),
        line((2.4, -1.0), (0.6, -0.2)),  # comes towards the robot
        line((1.4, -2.0), (1.4, 1.0)),  # crosses in front of it
        line((0.5, -0.3), (1.9, -0.4), (0.5, -0.5)),  # leads away and comes back
    ]
    expected = drawn_by_hand(free, paths, config)
    np.testing.assert_allclose(draw_target(free, *joined(paths), config), expected, atol=2e-3)  # cv2's kernel is cut


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.floats(0.1, 2.4), st.floats(-2.4, 2.4)), min_size=2, max_size=5), st.integers(0, 2**31))
def test_a_mirrored_world_has_the_mirrored_target(corners, seed):
    rng = np.random.default_rng(seed)
    free = np.repeat(np.repeat(rng.random((20, 20)) < 0.85, 5, 0), 5, 1)
    path = line(*corners) + 1e-4 * rng.random(2)  # on a border between cells no side is the mirror's
    run = np.zeros(len(path), int)
    config = HeatmapTargetConfig()
    there = draw_target(free, path, run, config)
    back = draw_target(np.ascontiguousarray(free[::-1]), path * [1, -1], run, config)
    np.testing.assert_allclose(back, there[::-1], atol=1e-6)


def test_pairs_mirror_cells_onto_cells_and_twice_is_none():
    pairs = heatmap_pairs([around_the_corner()])
    mirrored = pairs.mirrored()
    np.testing.assert_array_equal(mirrored.free[3], pairs.free[3, ::-1])
    np.testing.assert_array_equal(mirrored.joystick[:, 1], -pairs.joystick[:, 1])
    again = mirrored.mirrored()
    for name in ("free", "target", "joystick"):
        np.testing.assert_array_equal(getattr(again, name), getattr(pairs, name))


def test_the_way_leads_ahead_of_the_robot_and_around_the_corner():
    pairs = heatmap_pairs([around_the_corner()])
    straight = pairs.target[pairs.scan < 30].astype(float)
    assert (straight[:, 48:52, 70:].max(axis=1) > 0.3).all()  # all along x, laser to border
    assert not straight[:, 70:].any() and not straight[:, :30].any()
    corner = pairs.target[(pairs.scan > 58) & (pairs.scan < 64)].astype(float)
    assert len(corner) and (corner[:, 60:].max(axis=(1, 2)) > 0.5).all()
    assert not corner[:, :35].any()


def test_values_lie_between_0_and_1_and_reach_1():
    for paths in ("place", "own"):
        pairs = heatmap_pairs([around_the_corner()], HeatmapTargetConfig(paths=paths))
        assert pairs.target.min() >= 0
        np.testing.assert_array_equal(pairs.target.max(axis=(1, 2)), 1)


def test_runs_of_one_place_share_their_paths_wherever_their_odometry_began():
    ahead = corridor_log([(6.0, 0.8, 0.0)], (0.0, 0.0, 0.0), place="L")
    turning = around_the_corner(start=(1.0, 0.3, -0.05), place="L")
    alone, together = (heatmap_pairs(logs, HeatmapTargetConfig(spacing=0.0)) for logs in ([turning], [turning, ahead]))
    both = [pairs.target[(pairs.log == 0) & (pairs.scan == 60)][0].astype(float) for pairs in (alone, together)]
    assert both[1].sum() < both[0].sum() * 1.5  # the other run ended before this corner
    early = [pairs.target[(pairs.log == 0) & (pairs.scan == 0)][0].astype(float) for pairs in (alone, together)]
    assert early[1].sum() > early[0].sum() * 1.2  # two lines instead of one
    np.testing.assert_array_equal(np.unique(together.log), [0, 1])


def test_logs_that_name_no_place_share_nothing():
    one, other = around_the_corner(), corridor_log([(6.0, 0.8, 0.0)], (0.0, 0.4, 0.0))
    apart, together = heatmap_pairs([one]), heatmap_pairs([one, other])
    np.testing.assert_array_equal(together.target[together.log == 0], apart.target)


def test_the_own_way_is_the_one_after_the_scan_and_no_later_visit():
    later = [(2.0, 0.8, 0.0), (np.pi, 0.0, 1.0), (2.0, 0.8, 0.0), (np.pi, 0.0, 1.0), (1.6, 0.8, -0.3), (1.0, 0.8, 0.3)]
    log = corridor_log(later)
    own, place = (
        heatmap_pairs([log], HeatmapTargetConfig(paths=paths, spacing=0.0)).take(np.array([0])).target[0].astype(float)
        for paths in ("own", "place")
    )
    assert own[:40].max() < 0.02  # what the Gaussian leaves
    assert place[:40].max() > 0.4  # the last leg, which bends to the right
    pairs = heatmap_pairs([log], HeatmapTargetConfig(paths="own", spacing=0.0))
    last = pairs.target[pairs.scan == 105][0].astype(float)  # 10.3 s: back at the start, about to bend to the right
    assert last[:40].max() > 0.4
    assert last[50, 80:].max() < 0.02  # where the first leg went


@pytest.mark.parametrize("paths", ["place", "own"])
def test_what_was_never_driven_away_on_is_no_pair(paths):
    waiting = corridor_log([(2.0, 0.0, 0.0)])
    with pytest.raises(ValueError, match=r"1 logs hold no scan with a path .*no path"):
        heatmap_pairs([waiting], HeatmapTargetConfig(paths=paths))


def test_a_scan_that_sees_nothing_is_counted_and_left_out():
    log = around_the_corner()
    ranges = log.ranges.copy()
    ranges[:20] = np.nan
    blind = DriveLog(**{**vars(log), "ranges": ranges})
    pairs = heatmap_pairs([blind], HeatmapTargetConfig(spacing=0.0))
    assert pairs.dropped["sees nothing"] == 20
    assert pairs.scan.min() >= 20


def test_a_log_without_odometry_gives_no_pair_and_says_so():
    empty = DriveLog(scan_stamp=np.arange(3.0), ranges=np.ones((3, 5), np.float32))
    with pytest.raises(ValueError, match="no odometry: 3"):
        heatmap_pairs([empty])
    assert heatmap_pairs([empty, around_the_corner()]).dropped["no odometry"] >= 3
    with pytest.raises(ValueError, match="no scans"):
        heatmap_pairs([DriveLog(scan_stamp=np.zeros(0), ranges=np.zeros((0, 5), np.float32))])
    with pytest.raises(ValueError, match="at least one drive log"):
        heatmap_pairs([])


def test_scans_are_taken_a_spacing_of_way_apart():
    log = around_the_corner(speed=0.5)
    pairs = heatmap_pairs([log], HeatmapTargetConfig(spacing=0.5))
    kept = log.pose_at(log.scan_stamp[pairs.scan])
    step, turn = np.linalg.norm(np.diff(kept[:, :2], axis=0), axis=1), np.abs(np.diff(kept[:, 2]))
    assert (step + 0.5 * turn > 0.45).all()
    assert pairs.dropped["too near to the scan before"] > 50


@pytest.mark.parametrize("pose", ["here", "1 2", "1 2 nan", "1e300 0 0"])
def test_a_place_without_a_pose_is_a_data_error(pose):
    log = around_the_corner(place="L")
    with pytest.raises(DataError, match="T_place_odom"):
        heatmap_pairs([DriveLog(**{**vars(log), "metadata": {"place": "L", "T_place_odom": pose}})])


def test_an_odometry_that_is_no_vehicles_is_refused_before_it_fills_the_memory():
    log = around_the_corner()
    with pytest.raises(DataError, match=r"odometry of log 'corridor' is 1\S+e.06 m long, must be at most 100000 m"):
        heatmap_pairs([DriveLog(**{**vars(log), "pose": log.pose * [1e5, 1e5, 1]})])


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"paths": "some"}, "paths is 'some'"),
        ({"sigma": -1.0}, r"sigma is -1.0 m, must lie in \[0, 2.5 m\]"),
        ({"spacing": float("nan")}, "spacing is nan m"),
        ({"path_value": 1.0, "end_value": 0.5}, "must satisfy"),
    ],
)
def test_a_target_that_cannot_be_drawn_is_refused(changes, said):
    with pytest.raises(ValueError, match=said):
        HeatmapTargetConfig(**changes)


def test_no_path_makes_an_all_zero_target_and_another_window_is_refused():
    assert not draw_target(ALL_FREE, np.zeros((0, 2)), np.zeros(0, int), HeatmapTargetConfig()).any()
    with pytest.raises(ValueError, match="shape"):
        draw_target(np.ones((50, 50), bool), np.zeros((0, 2)), np.zeros(0, int), HeatmapTargetConfig())


@pytest.mark.realdata
def test_a_real_log_gives_a_pair_at_nearly_every_scan_that_is_taken(data_folder):
    log = open_log(data_folder / "logs" / "freiburg-079-corrected.log.gz").share(0.0, 0.2)
    pairs = heatmap_pairs([log], HeatmapTargetConfig(paths="own"))
    assert len(pairs) > 10 * pairs.dropped.get("no path", 0) > 0
    assert (pairs.target.max(axis=(1, 2)) == 1).all()


def test_runs_of_one_simulated_world_say_so_whatever_their_route():
    from lfdcore.simulated.courses import home, office
    from lfdcore.simulated.run import place_note

    one, two, other = (place_note(course) for course in (home(0), home(1), office()))
    assert one["place"] == two["place"] != other["place"]
    assert one["T_place_odom"] != two["T_place_odom"]
