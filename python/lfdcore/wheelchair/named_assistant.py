"""Assistants by what a command line calls them: a name, or the file of a learned model."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from lfdcore.wheelchair.assistants import Assistant, DriveAssistant, DynamicWindowAssistant, Supervised, Unassisted
from lfdcore.wheelchair.models import load_model
from lfdcore.wheelchair.observation import ChairGeometry

MakeAssistant = Callable[[ChairGeometry], Assistant]
"""Makes an assistant for a chair."""

NAMED: dict[str, MakeAssistant] = {"supervisor": Supervised, "dwa": DynamicWindowAssistant, "none": Unassisted}
"""Those that learn nothing"""


def assistant_maker(model: str) -> MakeAssistant:
    """What makes an assistant: a name of NAMED, or the file of a model that drives. ModelError and FileNotFoundError as
    load_model; ValueError for a model that drives nothing."""
    if model in NAMED:
        return NAMED[model]
    loaded = load_model(Path(model))
    if not loaded.drives:
        raise ValueError(f"{model} holds a {loaded.kind.removeprefix('lfdcore ')}, which drives nothing")
    return lambda chair: DriveAssistant(loaded.planner(chair), name=loaded.method)
