"""Before anything moves: have all topics spoken, of now, in known frames, and is the node the chair's one master?"""

from __future__ import annotations

import time
from typing import Any

from lfdcore.datasets.frame_tree import FrameTree, Mounting, nanoseconds
from lfdcore.ros.frames import Frames, frames_of, scan_mounting
from lfdcore.ros.options import NodeOptions
from lfdcore.ros.senses import Senses
from lfdcore.ros.topics import Commands, Inputs

LOOKED_EVERY = 0.05
"""[s] of wall time"""
SETTLED = 3.5
"""[s] of wall time for which nothing may be wrong: DDS participants announce themselves every 3 s"""
WARNED_EVERY = 1.0
"""[s] of wall time"""
OLDEST = 1.0
"""[s] A message that is older or younger than this is of another time."""


class Startup:
    """Looks at what has come in until nothing is wrong with it."""

    def __init__(
        self, node: Any, options: NodeOptions, senses: Senses, inputs: Inputs, commands: Commands, statics: FrameTree
    ) -> None:
        self._node, self._options, self._senses = node, options, senses
        self._inputs, self._commands, self._statics = inputs, commands, statics

    def wait(self) -> tuple[Frames, Mounting]:
        """-> the frames of this robot and how its scanner is mounted, once nothing was wrong for SETTLED.
        ValueError that says all that is wrong, once the options' wait is over."""
        begin = warned = wrong = time.monotonic()
        while (now := time.monotonic()) - wrong < SETTLED:
            problems = self._problems()
            wrong = now if problems else wrong
            if problems and now - begin >= self._options.wait:
                raise ValueError(f"after {self._options.wait:g} s: {'; '.join(problems)}")
            if problems and now - warned >= WARNED_EVERY:
                warned = now
                self._node.get_logger().warning(f"waiting: {'; '.join(problems)}")
            time.sleep(LOOKED_EVERY)
        return self._frames(), self._mounting()

    def _problems(self) -> list[str]:
        if self._now() == 0:
            return ["use_sim_time is true, but nothing came on /clock"]
        heard = self._silent() or self._of_another_time() or self._nonsense()
        return heard + self._commands.problems()

    def _silent(self) -> list[str]:
        senses, inputs = self._senses, self._inputs
        said = (
            (senses.scan_message, inputs.scan),
            (senses.odometry_message, inputs.odometry),
            (senses.joystick_message, inputs.joystick),
        )
        return [inputs.why_silent(subscription) for message, subscription in said if message is None]

    def _of_another_time(self) -> list[str]:
        """Of each topic whose newest message is not of now. A stick without stamps is of when it came."""
        stick = self._senses.stick()
        stamps = {
            self._options.scan: nanoseconds(self._senses.scan_message.header.stamp),
            self._options.odometry: nanoseconds(self._senses.odometry_message.header.stamp),
            self._options.joystick: 0 if stick is None else stick.stamp,
        }
        return [found for topic, stamp in stamps.items() if (found := self._off(topic, stamp))]

    def _off(self, topic: str, stamp: int) -> str | None:
        if stamp == 0:
            return f"messages on {topic} have no stamp"
        age = (self._now() - stamp) / 1e9
        if abs(age) <= OLDEST:
            return None
        off = f"{age:.1f} s old" if age > 0 else f"{-age:.1f} s in the future"
        return (
            f"the newest message on {topic} is {off} by this node's clock (silent since? clocks not set? use_sim_time?)"
        )

    def _nonsense(self) -> list[str]:
        options, axes = self._options, len(self._senses.joystick_message.axes)
        if max(options.axes) >= axes:
            return [f"{options.joystick} has {axes} axes, --axes {options.axes[0]},{options.axes[1]} counts from 0"]
        try:
            self._frames(), self._mounting()
        except ValueError as error:
            return [str(error)]
        return []

    def _frames(self) -> Frames:
        return frames_of(self._senses.scan_message, self._senses.odometry_message, self._options, self._statics)

    def _mounting(self) -> Mounting:
        return scan_mounting(self._senses.scan_message, self._senses.odometry_message, self._options, self._statics)

    def _now(self) -> int:
        return int(self._node.get_clock().now().nanoseconds)
