"""How long work reports that it goes on: a function that whoever asked for the work gives it."""

from collections.abc import Callable

Progress = Callable[[int, int], None]
"""Called with (done, total)."""
StageProgress = Callable[[str, int, int], None]
"""Called with (stage, done, total)."""


def silent(*_: object) -> None:
    """Reports to nobody."""
