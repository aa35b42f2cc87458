"""Re-exports lfdcore._core.grid."""

from lfdcore._core.grid import *  # noqa: F403
