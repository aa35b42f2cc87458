"""Which Python has ROS 2: the one that LFDCORE_ROS_PYTHON names, or this one; else a skip that says so."""

import os
import sys

import pytest

from ros_processes import has_ros


@pytest.fixture(scope="session")
def ros_python() -> str:
    """A Python with rclpy. What is named but cannot be used fails."""
    named = os.environ.get("LFDCORE_ROS_PYTHON")
    missing = has_ros(named or sys.executable)
    if missing and named:
        pytest.fail(f"LFDCORE_ROS_PYTHON: {missing}")
    if missing:
        pytest.skip(f"no ROS 2 here ({missing}); `make test-ros` runs these")
    return named or sys.executable
