"""Boxes, and grippers that sweep over them."""

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from lfdcore.humanoid.scene import Box, standing_box

Array = np.ndarray

RIGHT = (0.72, -0.32, 0.32)
BOX = standing_box(0.9, 0.4, 0.38, (0.8, 0.27))

coordinates = st.floats(-1.5, 1.5)
points = st.tuples(coordinates, coordinates, coordinates)
boxes = st.builds(Box, points, st.tuples(*[st.floats(0.05, 1.0)] * 3), st.floats(-3.2, 3.2))
paths = arrays(np.float64, (6, 3), elements=coordinates)


def sweep(box: Box = BOX, margin: float = 0.12, beyond: float = 0.12, x: float = 0.78, end: float = 0.04) -> Array:
    """Up beside the box, straight across `margin` above its top, `beyond` it, down to `end` above the top: (60, 3)."""
    right, left = box.centre[1] - box.size[1] / 2, box.centre[1] + box.size[1] / 2
    corners = [(right - 0.15, -0.08), (right - 0.15, box.top + margin), (left + beyond, box.top + margin)]
    corners.append((left + beyond, box.top + end))
    y, z = np.array(corners).T
    at = np.linspace(0, 3, 60)
    return np.stack([np.full(60, x), np.interp(at, np.arange(4), y), np.interp(at, np.arange(4), z)], axis=1)
