"""Re-exports lfdcore._core.planning."""

from lfdcore._core.planning import *  # noqa: F403
