"""Re-exports lfdcore._core.estimation."""

from lfdcore._core.estimation import *  # noqa: F403
