import numpy as np
import pytest

from lfdcore.estimation import RbfNetworkConfig, fit_rbf_network
from lfdcore.geometry import Pose2
from lfdcore.grid import LaserScan, read_beams
from lfdcore.wheelchair.beams import BeamGeometry
from lfdcore.wheelchair.primitives.beam_lengths import filled_lengths
from lfdcore.wheelchair.primitives.intention import IntentionConfig, IntentionModel
from lfdcore.wheelchair.primitives.local_paths import LocalPaths, extract_local_paths
from lfdcore.wheelchair.window import cell_centres, cell_keys, key_centres
from synthetic_drive import AHEAD, LEFT, T_BASE_LASER, corner_drive, scan_at


def slow_likelihoods(paths, config, joystick, scan, T_base_laser):
    """Sec. 3.3 cell by cell, each network fitted and asked alone."""
    both = LocalPaths.concatenate([paths, paths.mirrored()])
    keys = cell_keys(both.goal)
    geometry = BeamGeometry(len(scan.ranges), scan.angle_min, scan.angle_increment, T_base_laser)
    seen = filled_lengths(*read_beams(scan))
    scale = np.array([config.sigma_joystick, config.sigma_joystick, 2.5 * config.sigma_range])
    found = {}
    for key in np.unique(keys):
        mine = np.flatnonzero(keys == key)
        stick = both.joystick[mine] / np.linalg.norm(both.joystick[mine], axis=1)[:, None]
        inputs = np.column_stack([stick, both.beam_range[mine]]) / scale
        network = fit_rbf_network(inputs, np.ones(len(mine)), RbfNetworkConfig(sigma=1.0))
        (beam,), (distance,), (covered,) = geometry.locate(key_centres(np.array([key])))
        asked = np.r_[joystick / np.linalg.norm(joystick), min(seen[beam], geometry.caps[beam])] / scale
        hidden = covered and distance > seen[beam] + config.slack
        found[int(key)] = 0.0 if hidden else network.predict(asked[None])[0]
    return found


@pytest.mark.parametrize(
    ("pose", "stick"), [((0, 0, 0), AHEAD), ((5, 0, 0.2), LEFT), ((7, 3, 1.5), np.array([0.9, -0.2]))]
)
def test_every_cell_answers_as_its_own_network_asked_alone(corner_paths, pose, stick):
    config = IntentionConfig(frequency=0.0, floor=0.0)
    model = IntentionModel.fit(corner_paths, config)
    slow = slow_likelihoods(corner_paths, config, stick, scan_at(*pose), T_BASE_LASER)
    assert model.cells.tolist() == sorted(slow)
    likelihood = model.cell_likelihoods(stick, scan_at(*pose), T_BASE_LASER)
    np.testing.assert_allclose(likelihood, [slow[int(key)] for key in model.cells], atol=1e-9)


def test_the_map_sums_to_one_and_lies_where_the_scan_sees(corner_model):
    scan = scan_at(3.0, 0.0, 0.0)
    image = corner_model.intention.predict(AHEAD, scan, T_BASE_LASER)
    assert image.shape == (100, 100)
    assert image.dtype == np.float32
    assert image.sum(dtype=float) == pytest.approx(1.0, abs=1e-5)
    beyond_walls = np.abs(cell_centres()[..., 1]) > 1.3
    assert image[beyond_walls].sum() < 0.01


def test_the_stick_decides_between_going_on_and_turning(corner_model):
    intention = corner_model.intention
    scan = scan_at(4.6, 0.0, 0.0)
    ahead, _ = intention.goal(intention.predict(AHEAD, scan, T_BASE_LASER))
    scan = scan_at(6.0, 0.0, 0.3)
    left, _ = intention.goal(intention.predict(LEFT, scan, T_BASE_LASER))
    assert abs(np.arctan2(ahead[1], ahead[0])) < np.deg2rad(25)
    assert np.arctan2(left[1], left[0]) > np.deg2rad(30)


def test_a_mirrored_world_gives_the_mirrored_map(corner_paths):
    model = IntentionModel.fit(corner_paths)
    scan = scan_at(5.5, 0.1, 0.2)
    other = LaserScan(np.asarray(scan.ranges)[::-1].copy(), -np.pi / 2, np.pi / 180, 0.0, 30.0)
    image = model.predict(LEFT, scan, T_BASE_LASER)
    np.testing.assert_allclose(image, model.predict(LEFT * [1, -1], other, T_BASE_LASER)[::-1], atol=1e-6)


def test_the_visible_mask_keeps_goals_out_of_cells(corner_model):
    scan = scan_at(3.0, 0.0, 0.0)
    visible = cell_centres()[..., 0] < 1.5
    image = corner_model.intention.predict(AHEAD, scan, T_BASE_LASER, visible)
    assert image[~visible].sum() == 0
    assert image.sum(dtype=float) == pytest.approx(1.0, abs=1e-5)
    with pytest.raises(ValueError, match="visible mask has shape"):
        corner_model.intention.predict(AHEAD, scan, T_BASE_LASER, np.ones((10, 10), bool))


@pytest.mark.parametrize(
    ("stick", "spoil"),
    [
        ([0.0, 0.0], lambda ranges: ranges),
        ([0.01, 0.01], lambda ranges: ranges),
        ([-1.0, 0.0], lambda ranges: ranges),
        ([1.0, 0.0], lambda ranges: ranges * np.nan),
    ],
    ids=["stick at rest", "stick in the dead zone", "never demonstrated", "nothing measured"],
)
def test_nothing_likely_is_an_all_zero_map_and_no_goal(corner_model, stick, spoil):
    scan = scan_at(0.0, 0.0, 0.0)
    scan = LaserScan(spoil(np.array(scan.ranges)), scan.angle_min, scan.angle_increment, 0.0, 30.0)
    image = corner_model.intention.predict(np.array(stick), scan, T_BASE_LASER, np.abs(cell_centres()[..., 1]) < 2)
    assert image.sum() == 0
    assert corner_model.intention.goal(image) is None


@pytest.mark.parametrize("stick", [[np.nan, 0.0], [1.5, 0.0], [0.0, -np.inf], [1.0], [1.0, 0.0, 0.0]])
def test_a_stick_that_cannot_be_is_refused(corner_model, stick):
    with pytest.raises(ValueError, match="joystick is"):
        corner_model.intention.predict(np.array(stick), scan_at(0, 0, 0), T_BASE_LASER)


@pytest.mark.parametrize("beams", [91, 361, 721])
def test_another_number_of_beams_sees_the_same_intention(corner_model, beams):
    intention = corner_model.intention
    reference = intention.predict(AHEAD, scan_at(3, 0, 0), T_BASE_LASER)
    other = intention.predict(AHEAD, scan_at(3, 0, 0, beams), T_BASE_LASER)
    assert np.abs(reference - other).sum() < 0.35
    a, b = intention.goal(reference)[0], intention.goal(other)[0]
    assert np.linalg.norm(a - b) < 0.6


def test_a_few_nan_beams_change_little(corner_model):
    scan = scan_at(3, 0, 0)
    ranges = np.array(scan.ranges)
    ranges[::7] = np.nan
    broken = LaserScan(ranges, scan.angle_min, scan.angle_increment, 0.0, 30.0)
    a = corner_model.intention.predict(AHEAD, scan, T_BASE_LASER)
    b = corner_model.intention.predict(AHEAD, broken, T_BASE_LASER)
    assert np.abs(a - b).sum() < 0.2


def scan_with(value):
    """In the corner, by a scanner that measures from .25 m on, every fourth beam of which gives `value`."""
    scan = scan_at(3, 0, 0)
    ranges = np.array(scan.ranges)
    ranges[::4] = value
    return LaserScan(ranges, scan.angle_min, scan.angle_increment, 0.25, 30.0)


@pytest.mark.parametrize("value", [0.0, 0.125, -3.0])
def test_a_beam_below_range_min_is_one_that_measured_nothing(corner_model, value):
    asked = corner_model.intention.cell_likelihoods
    without = asked(AHEAD, scan_with(np.nan), T_BASE_LASER)
    np.testing.assert_array_equal(asked(AHEAD, scan_with(value), T_BASE_LASER), without)
    nothing = LaserScan(np.full(181, value, np.float32), -np.pi / 2, np.pi / 180, 0.25, 30.0)
    assert not asked(AHEAD, nothing, T_BASE_LASER).any()


def test_a_beam_that_is_too_close_sees_as_far_as_range_min(corner_model):
    asked = corner_model.intention.cell_likelihoods
    close = asked(AHEAD, scan_with(-np.inf), T_BASE_LASER)
    np.testing.assert_array_equal(close, asked(AHEAD, scan_with(0.25), T_BASE_LASER))
    assert close.sum() < asked(AHEAD, scan_with(np.nan), T_BASE_LASER).sum()


def test_with_everything_at_0_m_only_what_the_laser_cannot_judge_is_left(corner_model):
    scan = LaserScan(np.zeros(181, np.float32), -np.pi / 2, np.pi / 180, 0.0, 30.0)
    likelihood = corner_model.intention.cell_likelihoods(AHEAD, scan, T_BASE_LASER)
    assert likelihood[corner_model.intention.centres[:, 0] > 0.76].sum() == 0


def test_frequencies_count_the_demonstrations_of_every_cell(corner_paths):
    model = IntentionModel.fit(corner_paths, IntentionConfig(mirror=False))
    keys = cell_keys(corner_paths.goal)
    per_cell = np.add.reduceat(model.frequencies, np.asarray(model.bank.offsets)[:-1])
    assert per_cell.tolist() == [np.sum(keys == key) for key in model.cells]


def test_a_cell_reached_more_often_is_likelier(corner_paths):
    bare = IntentionModel.fit(corner_paths, IntentionConfig(frequency=0.0, blur=0.0))
    weighted = IntentionModel.fit(corner_paths, IntentionConfig(frequency=0.5, blur=0.0))
    scan = scan_at(1.0, 0.0, 0.0)
    a, b = (m.cell_likelihoods(AHEAD, scan, T_BASE_LASER) for m in (bare, weighted))
    likely = a > 0.9
    assert likely.sum() >= 3
    assert np.ptp(a[likely]) < 0.1
    often = np.add.reduceat(weighted.frequencies, np.asarray(weighted.bank.offsets)[:-1])[likely]
    assert b[likely][often.argmax()] > 1.5 * b[likely][often.argmin()]


def test_mirroring_doubles_what_was_seen(corner_paths):
    once = IntentionModel.fit(corner_paths, IntentionConfig(mirror=False))
    twice = IntentionModel.fit(corner_paths)
    assert set(once.cells.tolist()) < set(twice.cells.tolist())


def test_the_thesis_preset_changes_the_map(corner_paths):
    printed = IntentionModel.fit(corner_paths, IntentionConfig.thesis())
    assert printed.config == IntentionConfig(
        sigma_joystick=0.3, sigma_range=0.3, frequency=0.0, floor=0.0, blur=0.0, mirror=False
    )
    scan = scan_at(3, 0, 0)
    a = printed.predict(AHEAD, scan, T_BASE_LASER)
    b = IntentionModel.fit(corner_paths).predict(AHEAD, scan, T_BASE_LASER)
    assert np.abs(a - b).sum() > 0.1


def test_the_laser_may_sit_elsewhere_than_it_was_learned_with(corner_model):
    T = Pose2(0.2, 0.0, 0.0)
    scan = scan_at(3, 0, 0, T_base_laser=T)
    goal, _ = corner_model.intention.goal(corner_model.intention.predict(AHEAD, scan, T))
    assert abs(goal[1]) < 0.6


def test_demonstrations_without_paths_or_stick_are_refused():
    paths = extract_local_paths(corner_drive())
    still = LocalPaths(paths.joystick * 0, *(getattr(paths, n) for n in list(paths.__dataclass_fields__)[1:]))
    with pytest.raises(ValueError, match="has the stick pushed"):
        IntentionModel.fit(still)


@pytest.mark.parametrize("field", [{"sigma_joystick": 0.0}, {"sigma_range": np.nan}, {"blur": -1.0}])
def test_configs_out_of_range_are_refused_by_name(field):
    with pytest.raises(ValueError, match=next(iter(field))):
        IntentionConfig(**field)
