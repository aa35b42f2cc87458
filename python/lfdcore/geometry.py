"""Re-exports lfdcore._core.geometry."""

from lfdcore._core.geometry import *  # noqa: F403
