"""Where the defaults of a command come from."""

from enum import StrEnum


class Preset(StrEnum):
    """Where defaults come from."""

    default = "default"
    thesis = "thesis"
