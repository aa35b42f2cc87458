import pytest
from synthetic_drive import corner_drive

from lfdcore.training.drive_primitives import learn_drive
from lfdcore.wheelchair.primitives.local_paths import LocalPaths, extract_local_paths


@pytest.fixture(scope="session")
def corner_logs():
    return [corner_drive(offset) for offset in (-0.15, 0.0, 0.15)]


@pytest.fixture(scope="session")
def corner_paths(corner_logs):
    return LocalPaths.concatenate([extract_local_paths(log) for log in corner_logs])


@pytest.fixture(scope="session")
def corner_model(corner_logs):
    return learn_drive(corner_logs)
