"""Re-exports lfdcore._core.control."""

from lfdcore._core.control import *  # noqa: F403
