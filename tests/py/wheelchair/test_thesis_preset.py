"""The preset `thesis`: docs/thesis-preset.md lists every field it sets, and each of them changes an outcome.

A field counts as doing so if turning it back alone changes what the preset does, or setting it alone changes what the
defaults do: some fields only matter together with others (a patch kept clear of inflation, where nothing is inflated).
Fields are found by looking, so a new one fails here until the table has it and a scene shows what it does.
"""

import dataclasses
import re
from collections.abc import Callable, Iterator
from functools import cache
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from goal_worlds import GOALS, drive_to, drives
from lfdcore.datasets import open_log
from lfdcore.geometry import Pose2, Twist2
from lfdcore.grid import LaserScan, ObstaclePoints, OccupancyGrid
from lfdcore.humanoid.collaboration import CollaborationConfig, CollaborationModel
from lfdcore.simulated.courses import home
from lfdcore.simulated.drivers import ExpertDriver
from lfdcore.simulated.passing import Rectangle, demonstrate_passing
from lfdcore.simulated.run import run_drive
from lfdcore.simulation import ChairConfig, DrivingWorld, LidarConfig
from lfdcore.training.drive_heatmaps import HeatmapLearningConfig, learn_joystick
from lfdcore.training.drive_primitives import LearningConfig, learn_drive
from lfdcore.training.goals import GoalLearningConfig, learn_goals
from lfdcore.wheelchair.assistants import DriveAssistant, DriveAssistantConfig, Unassisted
from lfdcore.wheelchair.goals.model import GoalFilter
from lfdcore.wheelchair.goals.samples import drive_samples
from lfdcore.wheelchair.heatmaps.model import HeatmapModel
from lfdcore.wheelchair.heatmaps.planner import HeatmapPlanner, HeatmapPlannerConfig
from lfdcore.wheelchair.observation import ChairGeometry, Observation, observations
from lfdcore.wheelchair.planner import Planner
from lfdcore.wheelchair.primitives.model import DriveAssistantModel
from lfdcore.wheelchair.primitives.planner import PrimitivesPlanner, PrimitivesPlannerConfig
from lfdcore.wheelchair.primitives.prediction import PathPredictionConfig, PathPredictor
from observed import observed

CHAIR = ChairGeometry.thesis()

TABLE = Path(__file__).parents[3] / "docs" / "thesis-preset.md"
PRESETS: dict[str, tuple[Any, Any]] = {
    "learning": (LearningConfig.thesis(), LearningConfig()),
    "heatmap_learning": (HeatmapLearningConfig.thesis(), HeatmapLearningConfig()),
    "goal_learning": (GoalLearningConfig.thesis(), GoalLearningConfig()),
    "collaboration": (CollaborationConfig.thesis(), CollaborationConfig()),
    "assistant": (DriveAssistantConfig.thesis(), DriveAssistantConfig()),
    "primitives": (PrimitivesPlannerConfig.thesis(), PrimitivesPlannerConfig()),
    "heatmaps": (HeatmapPlannerConfig.thesis(), HeatmapPlannerConfig()),
    "prediction": (PathPredictionConfig.thesis(), PathPredictionConfig()),
}


# -- fields of nested configs, in Python (dataclasses) and from the core (properties) ---------------------------------


def field_names(config: Any) -> list[str]:
    if dataclasses.is_dataclass(config):
        return [field.name for field in dataclasses.fields(config)]
    return [name for name, value in vars(type(config)).items() if isinstance(value, property)]


def is_config(value: Any) -> bool:
    return type(value).__name__.endswith("Config")


def differing(preset: Any, default: Any, name: str) -> Iterator[tuple[str, Any, Any]]:
    for field in field_names(preset):
        ours, theirs, full = getattr(default, field), getattr(preset, field), f"{name}.{field}"
        if is_config(ours) and is_config(theirs):
            yield from differing(theirs, ours, full)
        elif ours != theirs:
            yield full, theirs, ours


def with_value(config: Any, path: list[str], value: Any) -> Any:
    """The config with the field at `path` set."""
    inner = value if len(path) == 1 else with_value(getattr(config, path[0]), path[1:], value)
    if dataclasses.is_dataclass(config):
        return dataclasses.replace(config, **{path[0]: inner})  # type: ignore[type-var]
    return type(config)(**{name: getattr(config, name) for name in field_names(config)} | {path[0]: inner})


SET = {name: (theirs, ours) for key, pair in PRESETS.items() for name, theirs, ours in differing(*pair, key)}


# -- the table --------------------------------------------------------------------------------------------------------


def shown(value: Any) -> str:
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, tuple):
        return ", ".join(map(shown, value))
    if isinstance(value, float | int):
        return f"{value:g}"
    return f"{type(value).__name__}()" if is_config(value) else str(value)


def table_rows() -> dict[str, list[str]]:
    rows = re.findall(r"^\| `([\w.]+)` \|(.*)\|$", TABLE.read_text(), flags=re.MULTILINE)
    return {name: [cell.strip() for cell in rest.split(" | ")] for name, rest in rows}


def test_the_table_lists_every_field_that_the_preset_sets_and_no_other() -> None:
    listed = table_rows()
    missing = [f"| `{name}` | {shown(a)} | {shown(b)} |" for name, (a, b) in SET.items() if name not in listed]
    assert not missing, f"{TABLE.name} lacks these rows:\n" + "\n".join(missing)
    extra = sorted(set(listed) - set(SET))
    assert not extra, f"{TABLE.name} lists {extra}, which the preset does not change"


@pytest.mark.parametrize("name", SET)
def test_a_row_has_the_printed_value_ours_a_source_and_a_reason(name: str) -> None:
    cells = table_rows()[name]
    assert cells[:2] == [shown(value) for value in SET[name]]
    assert len(cells) == 4
    assert all(cells)


# -- what a config does -----------------------------------------------------------------------------------------------

STICKS = [np.array(stick) for stick in ((0.8, 0.0), (0.6, 0.3), (0.25, -0.75), (0.3, 0.95))]


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """An expert's drive through the simulated home."""
    path, course = tmp_path_factory.mktemp("preset") / "home.mcap", home(2)
    run_drive(course, ExpertDriver(course), Unassisted(CHAIR), seed=1, log_path=path)
    return open_log(path)


@pytest.fixture(scope="module")
def restless(log: Any) -> Any:
    """The same drive with a stick that points anywhere: what it takes to fill the networks."""
    angle = np.random.default_rng(1).uniform(-np.pi, np.pi, len(log.joystick))
    return dataclasses.replace(log, joystick=np.stack([np.cos(angle), np.sin(angle)], axis=1))


@pytest.fixture(scope="module")
def seen(log: Any) -> list[Observation]:
    return list(observations(log))[::150]


@pytest.fixture(scope="module")
def model(log: Any) -> DriveAssistantModel:
    return learn_drive([log])


def learning_outcome(config: LearningConfig, logs: list[Any], seen: list[Observation]) -> Iterator[bytes]:
    """Intention maps, primitives and compliance maps."""
    model, mounting = learn_drive(logs, config), logs[0].T_base_laser
    yield from (model.compliance.map(stick).tobytes() for stick in STICKS)
    yield model.primitives.scaled_to(np.array([2.0, 0.9])).tobytes()
    yield from (model.intention.predict(stick, one.scan, mounting).tobytes() for one in seen for stick in STICKS)


def joystick_outcome(config: HeatmapLearningConfig, log: Any) -> Iterator[bytes]:
    """What sticks are taken to mean; of the preset's fields none is the network's."""
    model = learn_joystick([log], config)
    yield from (np.array(model.predict(stick)).tobytes() for stick in STICKS)


def goal_outcome(config: GoalLearningConfig) -> Iterator[bytes]:
    """Beliefs and the network's likelihoods along a drive whose driver rests the stick on the way, learned from such
    drives with a search as short as it can be: the preset sets none of its numbers."""
    network = dataclasses.replace(config.network, epochs=2)
    quick = dataclasses.replace(config, network=network, search_samples=40, searches=1, generations=2, subset=40)
    model = learn_goals([pausing(log) for log in drives(1)], GOALS, quick)
    samples = drive_samples(pausing(drive_to(0, 77)))
    yield model.network.predict(samples.pose, samples.joystick).tobytes()
    running = GoalFilter(model)
    for k in range(0, len(samples), 5):
        belief = running.update(samples.pose[k], samples.twist[k], samples.joystick[k])
        yield belief.mean.tobytes() + belief.covariance.tobytes()


def collaboration_outcome(config: CollaborationConfig) -> Iterator[bytes]:
    """The motion inferred from half of another partner's, of more demonstrations than parameters."""
    small = dataclasses.replace(config, basis_functions=3, steps=60)
    passes = [demonstrate_passing(Rectangle(100 + 3 * k, 80 + 2 * k), [9, k]) for k in range(20)]
    seen = demonstrate_passing(Rectangle(120, 100), [9, 99])
    yield (
        CollaborationModel.fit(passes, small).infer(seen.partial(share=0.5), seen.environment).robot_motion().tobytes()
    )


def pausing(log: Any) -> Any:
    """The drive with the stick let go for a second at its beginning."""
    stick = log.joystick.copy()
    stick[5:15] = 0.01
    return dataclasses.replace(log, joystick=stick)


def prediction_outcome(
    config: PathPredictionConfig, model: DriveAssistantModel, seen: list[Observation], mounting: Pose2
) -> Iterator[bytes]:
    """Predicted paths."""
    predictor = PathPredictor(model, config)
    for one in seen:
        path = predictor.predict(np.array(one.joystick), one.scan, mounting)
        yield b"" if path is None else path.tobytes()


class Scene:
    """A walled room of 12 x 5 m with boxes (x0, y0, x1, y1) [m], a start and what the stick does tick by tick."""

    def __init__(self, boxes: list[tuple[float, float, float, float]], start: Pose2, sticks: list[tuple[float, float]]):
        data = np.zeros((100, 240), np.int8)
        data[[0, -1]], data[:, [0, -1]] = 100, 100
        for x0, y0, x1, y1 in boxes:
            data[round(y0 / 0.05) : round(y1 / 0.05), round(x0 / 0.05) : round(x1 / 0.05)] = 100
        self.grid, self.start, self.sticks = OccupancyGrid(data, 0.05, (0.0, 0.0)), start, sticks

    def commands(self, assistant: DriveAssistant) -> Iterator[tuple[float, float]]:
        """The assistant's command at each tick of its drive through the scene."""
        world = DrivingWorld(self.grid, ChairConfig(), LidarConfig(), seed=1)
        world.reset(self.start)
        for tick, stick in enumerate(self.sticks):
            stamp, twist = tick / 10, world.state.twist
            seen = observed(stamp, world.scan(), stick, pose=world.odometry, twist=twist)
            command = assistant.update(seen).command
            world.step(command, 0.1)
            yield command.linear, command.angular


AHEAD, LEFT, SHARP_LEFT = (0.7, 0.0), (0.5, 0.4), (0.2, 0.7)
SCENES = [
    # past a pillar and through a gap between two thin walls, then a turn beside the one passed
    Scene(
        [(4.0, 2.3, 4.3, 2.6), (6.5, 0.0, 6.6, 1.9), (6.5, 3.0, 6.6, 5.0)],
        Pose2(1.0, 2.2, 0.1),
        [AHEAD] * 40 + [LEFT] * 30 + [SHARP_LEFT] * 20,
    ),
    # straight at a thin wall from near, beside another
    Scene([(3.0, 0.0, 3.05, 5.0), (1.0, 1.5, 2.5, 1.6)], Pose2(1.5, 2.05, 0.0), [AHEAD] * 30),
    # a stick held to one side in the open: more than a quarter turn
    Scene([], Pose2(5.0, 2.5, 0.0), [SHARP_LEFT] * 120),
]


OPEN_SCAN = LaserScan(np.full(181, np.inf, np.float32), -np.pi / 2, np.pi / 180, 0.0, 30.0)
WINDOWS = [
    # (boxes (x0, y0, x1, y1) [m] in base_link, stick): a trap to get out of; a gap hardly wider than the chair
    ([(1.0, -0.8, 1.1, 1.4), (0.0, 1.3, 1.1, 1.4)], (0.7, 0.2)),
    ([(-0.53, -0.43, 0.87, -0.33), (-0.53, 0.37, 0.9, 0.47)], (0.74, -0.3)),
]


def window(boxes: list[tuple[float, float, float, float]]) -> OccupancyGrid:
    data = np.zeros((100, 100), np.int8)
    for x0, y0, x1, y1 in np.rint((np.array(boxes) + 2.5) / 0.05).astype(int):
        data[y0:y1, x0:x1] = 100
    return OccupancyGrid(data, 0.05, (-2.5, -2.5))


def planned_paths(planner: Planner) -> Iterator[bytes]:
    """Paths among obstacles that the present scan does not show."""
    for boxes, stick in WINDOWS:
        grid = window(boxes)
        iy, ix = np.nonzero(grid.data)
        obstacles = ObstaclePoints(np.stack([ix + 0.5, iy + 0.5], axis=1) * 0.05 - 2.5)
        plan = planner.plan(observed(0.0, OPEN_SCAN, stick, twist=Twist2(0.3, 0.0)), grid, obstacles)
        yield b"" if plan is None else plan.path.tobytes()


def landscapes(planner: HeatmapPlanner) -> Iterator[bytes]:
    """Values after Q-learning over the same windows: its last sweep shows in them, if not in a path."""
    for boxes, stick in WINDOWS:
        grid = window(boxes)
        heat = planner.heat(observed(0.0, OPEN_SCAN, stick), grid)
        assert heat is not None
        yield planner.solve(grid, heat, 0.25).values().tobytes()


def driven(planner: Planner, config: DriveAssistantConfig | None = None) -> Iterator[Any]:
    """Commands along drives through scenes."""
    assistant = DriveAssistant(planner, config)
    for scene in SCENES:
        assistant.reset()
        yield from scene.commands(assistant)


def assistant_outcome(
    config: DriveAssistantConfig, model: DriveAssistantModel, heatmaps: HeatmapModel
) -> Iterator[Any]:
    """Drives along the paths of both methods."""
    yield from driven(model.planner(CHAIR), config)
    yield from driven(heatmaps.planner(CHAIR), config)


def primitives_outcome(config: PrimitivesPlannerConfig, model: DriveAssistantModel) -> Iterator[Any]:
    """Paths in hand-made windows, drives along paths."""
    planner = PrimitivesPlanner(model, config, CHAIR)
    yield from planned_paths(planner)
    yield from driven(planner)


def heatmaps_outcome(config: HeatmapPlannerConfig, model: HeatmapModel) -> Iterator[Any]:
    """As primitives', and what their paths are drawn from."""
    planner = HeatmapPlanner(model, config, CHAIR)
    yield from planned_paths(planner)
    yield from landscapes(planner)
    yield from driven(planner)


@pytest.fixture(scope="module")
def outcome(
    log: Any, restless: Any, seen: list[Observation], model: DriveAssistantModel, heatmap_model: Path
) -> Callable[[str, Any], Iterator[Any]]:
    """(config's kind, config) -> its outcome, piece by piece."""

    heatmaps = HeatmapModel.load(heatmap_model)
    outcomes: dict[str, Callable[[Any], Iterator[Any]]] = {
        "learning": lambda config: learning_outcome(config, [log, restless], seen),
        "heatmap_learning": lambda config: joystick_outcome(config, log),
        "goal_learning": goal_outcome,
        "collaboration": collaboration_outcome,
        "prediction": lambda config: prediction_outcome(config, model, seen, log.T_base_laser),
        "assistant": lambda config: assistant_outcome(config, model, heatmaps),
        "primitives": lambda config: primitives_outcome(config, model),
        "heatmaps": lambda config: heatmaps_outcome(config, heatmaps),
    }
    return lambda kind, config: outcomes[kind](config)


@pytest.fixture(scope="module")
def whole_outcome(outcome: Callable[[str, Any], Iterator[Any]]) -> Callable[[str, int], list[Any]]:
    """(kind, 0 the preset or 1 the defaults) -> its outcome."""
    return cache(lambda kind, which: list(outcome(kind, PRESETS[kind][which])))


@pytest.mark.parametrize("name", SET)
def test_each_field_of_the_preset_changes_an_outcome(
    name: str, outcome: Callable[[str, Any], Iterator[Any]], whole_outcome: Callable[[str, int], list[Any]]
) -> None:
    kind, *path = name.split(".")
    for base, value in ((0, SET[name][1]), (1, SET[name][0])):  # turned back in the preset, then set in the defaults
        try:
            config = with_value(PRESETS[kind][base], path, value)
        except ValueError:  # refused beside the other fields: the other way round must show it
            continue
        changed = outcome(kind, config)
        if any(a != b for a, b in zip_longest(changed, whole_outcome(kind, base))):
            return
    pytest.fail(f"{name} changes nothing in any scene: add a scene that shows what it does, or leave it out")


@pytest.mark.parametrize("kind", PRESETS)
def test_the_same_config_gives_the_same_outcome(
    kind: str, outcome: Callable[[str, Any], Iterator[Any]], whole_outcome: Callable[[str, int], list[Any]]
) -> None:
    """Without this, the test above would pass for fields that do nothing."""
    assert list(outcome(kind, PRESETS[kind][0])) == whole_outcome(kind, 0)
