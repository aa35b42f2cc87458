"""What comes in is taken in by a thread of its own, so that the loop never waits for it."""

from __future__ import annotations

import threading
from typing import Any


class Spinning:
    """Lets an rclpy executor work until `end`."""

    def __init__(self, executor: Any) -> None:
        self._executor = executor
        self._error: BaseException | None = None
        self._ending = False
        self._thread = threading.Thread(target=self._spin, name="spinning", daemon=True)
        self._thread.start()

    def _spin(self) -> None:
        try:
            self._executor.spin()
        except BaseException as error:
            self._error = error

    def require_alive(self) -> None:
        """RuntimeError where nothing is taken in any more."""
        if not self._thread.is_alive() and not self._ending:
            raise RuntimeError("no messages are taken in any more") from self._error

    def end(self) -> None:
        """Takes nothing in any more; waits a second at most for what is being taken in."""
        self._ending = True
        self._executor.shutdown(timeout_sec=1.0)
        self._thread.join(timeout=1.0)
