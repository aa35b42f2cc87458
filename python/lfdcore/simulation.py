"""Re-exports lfdcore._core.simulation."""

from lfdcore._core.simulation import *  # noqa: F403
