"""A button that puts the assistant aside: the driver's own input goes through, supervised."""

from __future__ import annotations

from collections.abc import Callable

from lfdcore.geometry import Twist2
from lfdcore.wheelchair.assistants import Assistant, Supervised
from lfdcore.wheelchair.observation import Assistance, Observation
from lfdcore.wheelchair.watch import SILENT, is_neutral


class ManualOverride:
    """An assistant, and the bare supervisor in its place as long as `pressed()`. Who takes over begins anew: the chair
    stands until the stick is back at neutral, as the new one knows nothing of what the other did not trust. Then it
    creeps until it has seen its surroundings."""

    def __init__(self, assistant: Assistant, pressed: Callable[[], bool]) -> None:
        self.name = assistant.name
        self.chair = assistant.chair
        self._assistant, self._own = assistant, Supervised(assistant.chair)
        self._pressed = pressed
        self._active: Assistant = assistant
        self._waits = False

    def reset(self) -> None:
        """Forgets everything about the drive so far."""
        self._assistant.reset()
        self._own.reset()
        self._waits = False

    def update(self, observation: Observation) -> Assistance:
        """Of the one whose turn it is; after a change, mode silent until the stick is at neutral."""
        active = self._own if self._pressed() else self._assistant
        self._waits = self._waits or active is not self._active
        self._active = active
        if self._waits and not is_neutral(observation):
            return Assistance(Twist2(), mode=SILENT)
        if self._waits:
            active.reset()
        self._waits = False
        return active.update(observation)
