"""How far the beams of a scan see, with the gaps filled: what is learned asks each beam, measured or not (Sec. 3.3)."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


def measured_beams(lengths: Floats, hit: Mask) -> Mask:
    """Which beams measured anything, of lengths [m] and hits as lfdcore.grid.read_beams gives them, any shape."""
    return hit | (lengths > 0)


def filled_lengths(lengths: Floats, hit: Mask) -> Floats:
    """Lengths (B,) or (S, B) [m] as lfdcore.grid.read_beams gives them, with a number for every beam.

    For a beam that measured nothing the nearest beam of its scan that did stands in (ties: the lower index). A scan
    without any measurement keeps 0 everywhere: nothing is visible in it. ValueError for scans without beams.
    """
    if lengths.shape[-1] == 0:
        raise ValueError("a scan has 0 beams, at least 1 is needed")
    known = measured_beams(lengths, hit)
    filled = lengths.copy()
    for row, measured in zip(np.atleast_2d(filled), np.atleast_2d(known), strict=True):
        if measured.any() and not measured.all():
            row[:] = row[_nearest(measured)]
    return filled


def _nearest(measured: Mask) -> NDArray[np.intp]:
    """For each beam the nearest that measured -> (B,)."""
    known, index = np.flatnonzero(measured), np.arange(len(measured))
    after = np.searchsorted(known, index)
    low, high = known[np.maximum(after - 1, 0)], known[np.minimum(after, len(known) - 1)]
    return np.where(np.abs(index - low) <= np.abs(high - index), low, high)
