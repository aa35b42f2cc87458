"""The smooth move from rest to rest by minimum jerk (Flash and Hogan 1985), which people's reaches come near to."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def minimum_jerk(s: Array) -> Array:
    """S(s) = 10 s^3 - 15 s^4 + 6 s^5: how much of a move is done at shares s of its time, s cut to [0, 1]."""
    s = np.clip(s, 0, 1)
    return s**3 * (10 - 15 * s + 6 * s**2)
