"""Real data for tests: the folder that LFDCORE_DATA names, or a skip that says so (a failure where CI expects it)."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from lfdcore.study.goals.drives import GoalDrives


@pytest.fixture(scope="session")
def data_folder() -> Path:
    """The folder with real logs and maps."""
    folder = os.environ.get("LFDCORE_DATA")
    if folder:
        return Path(folder)
    if os.environ.get("LFDCORE_REQUIRE_DATA"):
        pytest.fail("LFDCORE_REQUIRE_DATA is set, but LFDCORE_DATA is not")
    pytest.skip("LFDCORE_DATA is not set: no real logs and maps at hand")


@pytest.fixture(scope="session")
def home_model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file of an assistant that learned from an expert in the training home (about 2 s, once a session)."""
    from lfdcore.study.demonstrations import learn_from_demonstrations

    return learn_from_demonstrations(tmp_path_factory.mktemp("home_model"), seed=1)


@pytest.fixture(scope="session")
def heatmap_model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file of heatmaps that a small network learned from four runs in the mazes (about 10 s, once a session)."""
    from lfdcore.datasets import open_log
    from lfdcore.study.demonstrations import demonstrate_in_mazes
    from lfdcore.training.drive_heatmaps import HeatmapLearningConfig, learn_heatmaps
    from lfdcore.training.parts.heatmap_net import HeatmapNetConfig

    folder = tmp_path_factory.mktemp("heatmap_model")
    drives = demonstrate_in_mazes(folder, seed=1, runs=4, processes=1)
    config = HeatmapLearningConfig(network=HeatmapNetConfig(width=8, epochs=4))
    learned = learn_heatmaps([open_log(path) for path in drives.paths], config)
    path = folder / "heatmaps.safetensors"
    learned.model.save(path)
    return path


@pytest.fixture(scope="session")
def goal_drives(tmp_path_factory: pytest.TempPathFactory) -> GoalDrives:
    """All 36 drives to the destinations of the goal building, with their logs (about 15 s, once a session)."""
    from lfdcore.study.goals.drives import record_goal_drives

    return record_goal_drives(tmp_path_factory.mktemp("goal_drives"), processes=2)


@pytest.fixture(scope="session")
def corner_logs():
    from synthetic_drive import corner_drive

    return [corner_drive(offset) for offset in (-0.15, 0.0, 0.15)]


@pytest.fixture(scope="session")
def corner_paths(corner_logs):
    from lfdcore.wheelchair.primitives.local_paths import LocalPaths, extract_local_paths

    return LocalPaths.concatenate([extract_local_paths(log) for log in corner_logs])


@pytest.fixture(scope="session")
def corner_model(corner_logs):
    from lfdcore.training.drive_primitives import learn_drive

    return learn_drive(corner_logs)
