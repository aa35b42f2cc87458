"""A button that puts the assistant aside: the driver's own input goes through, supervised."""

from __future__ import annotations

from collections.abc import Callable

from lfdcore.wheelchair.assistants import Assistant, Supervised
from lfdcore.wheelchair.observation import Assistance, Observation


class ManualOverride:
    """An assistant, and the bare supervisor in its place as long as `pressed()`. Who takes over begins anew: it knows
    nothing of what was seen before, and creeps until it has seen its surroundings."""

    def __init__(self, assistant: Assistant, pressed: Callable[[], bool]) -> None:
        self.name = assistant.name
        self.chair = assistant.chair
        self._assistant, self._own = assistant, Supervised(assistant.chair)
        self._pressed = pressed
        self._active: Assistant = assistant

    def reset(self) -> None:
        """Forgets everything about the drive so far."""
        self._assistant.reset()
        self._own.reset()

    def update(self, observation: Observation) -> Assistance:
        """Of the one whose turn it is."""
        active = self._own if self._pressed() else self._assistant
        if active is not self._active:
            active.reset()
        self._active = active
        return active.update(observation)
