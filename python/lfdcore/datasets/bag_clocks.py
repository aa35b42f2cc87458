"""One clock for the streams of a bag: headers' stamps where they agree, times of receipt where they do not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Nanoseconds = NDArray[np.int64]

APART = 1.0
"""[s] by which the headers of two streams may differ, each against the times of receipt, and be of one clock"""
STEADY = 1.0
"""[s] of spread between headers and receipt, beyond which receipt says nothing of when something was"""


@dataclass
class Times:
    """When the records of one stream were, by whom."""

    topic: str
    headers: list[int] = field(default_factory=list)
    """[ns]; 0 where there is none"""
    received: list[int] = field(default_factory=list)
    """[ns]"""

    def add(self, header: int, received: int) -> None:
        """Takes in one record's."""
        self.headers.append(header)
        self.received.append(received)


@dataclass(frozen=True)
class Timed:
    """The records of a stream that have a time, on the common clock."""

    kept: NDArray[np.intp]
    """(K,) indices into the stream"""
    stamps: Nanoseconds
    """(K,) [ns]"""
    noted: str = ""
    """how they came about, if not by their headers"""


def on_one_clock(streams: Mapping[str, Times], reference: str) -> dict[str, Timed]:
    """The streams on the clock of the headers of `reference` (on receipt's where it has none). Records without a time
    in a stream whose others have one are left out. ValueError, naming both topics and their times, for a stream of
    another clock where times of receipt cannot tell."""
    clock = _offset(streams[reference])
    return {role: _timed(times, streams[reference], clock) for role, times in streams.items()}


@dataclass(frozen=True)
class _Offset:
    """Of a stream's headers from receipt."""

    median: float
    """[ns]"""
    spread: float
    """[ns] of the middle half"""


def _offset(times: Times) -> _Offset | None:
    """None without a single header that has a time"""
    headers, received = np.array(times.headers, np.int64), np.array(times.received, np.int64)
    dated = headers != 0
    if not dated.any():
        return None
    low, middle, high = np.percentile((headers - received)[dated].astype(float), [25, 50, 75])
    return _Offset(float(middle), float(high - low))


def _timed(times: Times, reference: Times, clock: _Offset | None) -> Timed:
    headers, received = np.array(times.headers, np.int64), np.array(times.received, np.int64)
    own = _offset(times)
    if own is None:
        return _by_receipt(times, reference, received, clock, "no header has a time")
    same = (clock is None and abs(own.median) <= APART * 1e9) or (
        clock is not None and abs(own.median - clock.median) <= APART * 1e9
    )
    if not same and clock is not None and (own.spread > STEADY * 1e9 or clock.spread > STEADY * 1e9):
        same = _overlap(headers[headers != 0], np.array(reference.headers, np.int64))
        if not same:
            raise ValueError(_two_clocks(times, reference))
    if not same:
        apart = (own.median - (0 if clock is None else clock.median)) / 1e9
        return _by_receipt(times, reference, received, clock, f"its own clock is {apart:+.6g} s off")
    kept = np.flatnonzero(headers)
    noted = f"{len(headers) - len(kept)} without a time left out" if len(kept) < len(headers) else ""
    return Timed(kept, headers[kept], noted)


def _by_receipt(times: Times, reference: Times, received: Nanoseconds, clock: _Offset | None, why: str) -> Timed:
    if clock is not None and clock.spread > STEADY * 1e9:
        raise ValueError(f"{why} on {times.topic}, and {_two_clocks(times, reference)}")
    shift = 0 if clock is None else round(clock.median)
    return Timed(np.arange(len(received)), received + shift, f"by receipt: {why}")


def _overlap(a: Nanoseconds, b: Nanoseconds) -> bool:
    b = b[b != 0]
    return bool(len(a) and len(b) and a.min() <= b.max() and b.min() <= a.max())


def _two_clocks(times: Times, reference: Times) -> str:
    return (
        f"{times.topic} is from {_span(times)}, {reference.topic} from {_span(reference)}: these are two clocks, and "
        "the times of receipt do not tell how far they are apart"
    )


def _span(times: Times) -> str:
    stamps = [stamp for stamp in times.headers if stamp] or times.received
    return f"{min(stamps) / 1e9:.3f} to {max(stamps) / 1e9:.3f} s"
