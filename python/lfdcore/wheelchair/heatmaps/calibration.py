"""What a heatmap's values mean (not in the text): how often a driver's path crosses cells of that value.

A heatmap (Sec. 4.3) is scaled by its maximum and says only where to go rather. On runs that were not trained on, the
share of crossed cells is looked up value by value and made monotone (isotonic regression); the table goes with the
model.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
BINS = 64


@dataclass(frozen=True, eq=False)
class HeatmapCalibration:
    """A table from heat to probability: heat (K,) in [0, 1], strictly rising; probability (K,) in [0, 1], not falling.
    Linear between, constant beyond."""

    heat: Floats
    probability: Floats

    def __post_init__(self) -> None:
        heat, probability = self.heat, self.probability
        if heat.ndim != 1 or not len(heat) or heat.shape != probability.shape:
            raise ValueError(f"heat {heat.shape} and probability {probability.shape} must be (K,) with K >= 1")
        if not (np.isfinite(heat).all() and (np.diff(heat) > 0).all()):
            raise ValueError("heat must be finite and rise strictly")
        if not ((probability >= 0) & (probability <= 1)).all() or (np.diff(probability) < 0).any():
            raise ValueError("probability must lie in [0, 1] and not fall")

    @classmethod
    def fit(cls, heat: NDArray[np.floating], crossed: NDArray[np.bool_]) -> HeatmapCalibration:
        """From cells (N,) of held-out runs: their heat and whether the path crossed them. At most 64 bins of heat with
        equally many crossings, pooled until they do not fall. ValueError without cells or for heat outside [0, 1]."""
        values, happened = np.ravel(heat).astype(np.float64), np.ravel(crossed).astype(bool)
        if values.shape != happened.shape or not len(values):
            raise ValueError(f"{len(values)} cells of heat and {len(happened)} of crossings: needs as many, at least 1")
        if not ((values >= 0) & (values <= 1)).all():
            raise ValueError("heat must lie in [0, 1]")
        edges = np.unique(np.quantile(values[happened] if happened.any() else values, np.arange(1, BINS) / BINS))
        bins = np.searchsorted(edges, values, side="right")
        count = np.bincount(bins, minlength=len(edges) + 1)
        mean = np.bincount(bins, values, len(count)) / np.maximum(count, 1)
        hits = np.bincount(bins, happened, len(count))
        kept = count > 0
        mean, share = mean[kept], pooled(hits[kept] / count[kept], count[kept].astype(np.float64))
        rising = np.r_[True, np.diff(mean) > 0]
        return cls(mean[rising], share[rising])

    def probabilities(self, heatmap: NDArray[np.floating]) -> NDArray[np.float32]:
        """Heat of any shape, in [0, 1] -> probability of being crossed, of the same shape."""
        return np.asarray(np.interp(heatmap, self.heat, self.probability), np.float32)


def pooled(values: Floats, weights: Floats) -> Floats:
    """Isotonic regression: the non-falling (K,) nearest to `values` in weighted least squares (pool adjacent
    violators)."""
    blocks: list[tuple[float, float, int]] = []  # mean, weight, length
    for value, weight in zip(values.tolist(), weights.tolist(), strict=True):
        block = (value, weight, 1)
        while blocks and blocks[-1][0] >= block[0]:
            mean, heavy, length = blocks.pop()
            total = heavy + block[1]
            block = ((mean * heavy + block[0] * block[1]) / total, total, length + block[2])
        blocks.append(block)
    return np.repeat([mean for mean, _, _ in blocks], [length for _, _, length in blocks])
