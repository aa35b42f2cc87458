import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lfdcore.control import pure_pursuit
from lfdcore.wheelchair.primitives.compliance import ComplianceConfig, ComplianceModel, control_points
from lfdcore.wheelchair.primitives.local_paths import LocalPaths, extract_local_paths
from lfdcore.wheelchair.window import cell_centres
from synthetic_drive import corner_drive


def at(degrees, distance=0.8):
    return distance * np.array([np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))])


def test_control_points_are_those_of_pure_pursuit(corner_paths):
    for path in corner_paths.paths[::7]:
        for distance in (0.2, 0.5, 0.8):
            if np.hypot(*path[-1]) > distance:
                (point,) = control_points(path, np.array([distance]))
                np.testing.assert_allclose(point, pure_pursuit(path, distance, 0.5).control_point, atol=1e-6)


def test_control_points_beyond_the_path_are_nan():
    path = np.array([[0.0, 0.0], [0.5, 0.0]])
    np.testing.assert_allclose(control_points(path, np.array([0.25])), [[0.25, 0.0]])
    assert np.isnan(control_points(path, np.array([0.6]))).all()


def test_demonstrations_comply_with_themselves(corner_paths):
    model = ComplianceModel.fit(corner_paths)
    for share in (0.4, 0.8):
        values = [
            model.compliance(point[0], stick)
            for path, stick in zip(corner_paths.paths, corner_paths.joystick, strict=True)
            if np.isfinite(point := control_points(path, np.array([share]))).all()
        ]
        assert len(values) > 100
        assert np.mean(values) > 0.9
        assert np.mean(np.array(values) >= 0.9) > 0.75


def test_a_point_on_the_other_side_does_not_comply(corner_model):
    compliance = corner_model.compliance
    left = np.array([0.5, 0.5])
    assert compliance.compliance(at(23), left) > 0.9
    assert compliance.compliance(at(-23), left) < 0.1
    assert compliance.compliance(at(180), np.array([1.0, 0.0])) == 0.0


def test_a_shorter_look_ahead_is_understood(corner_model):
    compliance = corner_model.compliance
    for distance in (0.25, 0.3, 0.5, 0.8, 1.2):
        assert compliance.compliance(at(0, distance), np.array([1.0, 0.0])) > 0.9
        assert compliance.compliance(at(-40, distance), np.array([1.0, 0.0])) < 0.1


def test_the_thesis_sigma_is_more_permissive(corner_paths):
    sharp = ComplianceModel.fit(corner_paths)
    printed = ComplianceModel.fit(corner_paths, ComplianceConfig.thesis())
    assert printed.config == ComplianceConfig(sigma=0.3, shares=(1.0,), max_centres=20, mirror=False)
    angles = np.arange(0, 91, 5)
    stick = at(60, 1.0)  # a stick that nobody pushed so
    points = np.array([at(angle) for angle in angles])
    assert printed.compliances(points, stick).sum() > 2 * sharp.compliances(points, stick).sum()


def test_only_the_direction_of_the_stick_counts(corner_model):
    points = cell_centres()[40:60:3, 55:65:3].reshape(-1, 2)
    full, half = (corner_model.compliance.compliances(points, push * np.array([0.9, 0.3])) for push in (1.0, 0.5))
    np.testing.assert_allclose(full, half, atol=1e-12)


def test_left_and_right_are_treated_alike(corner_model):
    points = cell_centres()[::7, 50::7].reshape(-1, 2)
    stick, flip = np.array([0.6, 0.4]), np.array([1.0, -1.0])
    a = corner_model.compliance.compliances(points, stick)
    b = corner_model.compliance.compliances(points * flip, stick * flip)
    np.testing.assert_allclose(a, b, atol=1e-6)


def test_a_stick_at_rest_complies_with_nothing(corner_model):
    assert corner_model.compliance.compliance(at(0), np.array([0.0, 0.0])) == 0.0
    assert corner_model.compliance.compliance(at(0), np.array([0.02, 0.0])) == 0.0


@settings(max_examples=300, deadline=None)
@given(st.floats(-4, 4), st.floats(-4, 4), st.floats(-1, 1), st.floats(-1, 1))
def test_compliance_lies_in_0_to_1(model_of_corners, x, y, forward, left):
    if np.hypot(x, y) > 1e-6:
        assert 0.0 <= model_of_corners.compliance(np.array([x, y]), np.array([forward, left])) <= 1.0


@pytest.fixture(scope="module")
def model_of_corners(corner_model):
    return corner_model.compliance


def test_compliance_has_no_steps_between_control_points(corner_model):
    angles = np.linspace(-60, 60, 2000)
    values = corner_model.compliance.compliances(np.array([at(a, 0.61) for a in angles]), np.array([0.8, 0.2]))
    assert np.abs(np.diff(values)).max() < 0.02


def test_the_map_holds_the_compliance_of_each_cell_within_the_look_ahead(corner_model):
    stick = np.array([0.7, 0.3])
    image = corner_model.compliance.map(stick)
    assert image.shape == (100, 100)
    centres = cell_centres()
    near = np.hypot(*centres.transpose(2, 0, 1)) <= 0.8
    assert (image[~near] == 0).all()
    for iy, ix in np.argwhere(near)[::50]:
        assert image[iy, ix] == pytest.approx(corner_model.compliance.compliance(centres[iy, ix], stick), abs=1e-6)
    assert image[50:].sum() > image[:50].sum()


@pytest.mark.parametrize(
    ("point", "stick", "message"),
    [
        ([0.0, 0.0], [1.0, 0.0], "control_point"),
        ([np.nan, 0.0], [1.0, 0.0], "control_point"),
        ([0.8, 0.0], [np.nan, 0.0], "joystick"),
        ([0.8, 0.0], [2.0, 0.0], "joystick"),
    ],
)
def test_values_that_cannot_be_are_refused_by_name(corner_model, point, stick, message):
    with pytest.raises(ValueError, match=message):
        corner_model.compliance.compliance(np.array(point), np.array(stick))


def test_demonstrations_that_never_reach_a_control_point_are_refused():
    paths = extract_local_paths(corner_drive())
    short = LocalPaths(*(getattr(paths, n)[:3] for n in list(paths.__dataclass_fields__)[:-1]))
    short.paths[:] = [path[:2] for path in short.paths]
    with pytest.raises(ValueError, match=r"none of 3 local paths reaches 0\.2 m"):
        ComplianceModel.fit(short)


@pytest.mark.parametrize("field", [{"look_ahead": 0.0}, {"shares": ()}, {"shares": (1.0, 0.5)}, {"shares": (1.5,)}])
def test_configs_out_of_range_are_refused_by_name(field):
    with pytest.raises(ValueError, match=next(iter(field))):
        ComplianceConfig(**field)
