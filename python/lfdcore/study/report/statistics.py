"""Intervals and paired tests for study tables; every figure with its n, spread and seed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Summary:
    """A sample in figures. NaN values are left out of everything but `missing`."""

    n: int
    missing: int
    mean: float
    sd: float
    low: float
    """of the 95 % interval of the mean"""
    high: float


def summarise(values: ArrayLike) -> Summary:
    """Mean, standard deviation (n - 1) and Student's 95 % interval of the mean of values (n,)."""
    x = np.asarray(values, float)
    good = x[np.isfinite(x)]
    n = len(good)
    if n == 0:
        return Summary(0, len(x), *[float("nan")] * 4)
    mean = float(good.mean())
    if n == 1:
        return Summary(1, len(x) - 1, mean, float("nan"), float("nan"), float("nan"))
    sd = float(good.std(ddof=1))
    half = float(stats.t.ppf(0.975, n - 1)) * sd / np.sqrt(n)
    return Summary(n, len(x) - n, mean, sd, mean - half, mean + half)


def summarise_bounded(values: ArrayLike, seed: int = 1, draws: int = 4000) -> Summary:
    """As summarise, but with the 95 % percentile interval of a bootstrap, for counts and shares of values (n,).

    It cannot leave the range of the values, as Student's does near a bound; of few values it is too narrow. The same
    seed gives the same interval.
    """
    s = summarise(values)
    if s.n < 2:
        return s
    x = np.asarray(values, float)
    low, high = block_bootstrap(x[np.isfinite(x)][:, None], np.arange(s.n), seed, draws)
    return replace(s, low=float(low[0]), high=float(high[0]))


def paired_ratio(a: ArrayLike, b: ArrayLike, both: ArrayLike) -> tuple[float, int]:
    """Mean of b over mean of a (n,), of the finite pairs for which `both` holds -> ratio, number of those pairs.

    The ratio is NaN without a pair.
    """
    x, y, used = np.asarray(a, float), np.asarray(b, float), np.asarray(both, bool)
    if not x.shape == y.shape == used.shape:
        raise ValueError(f"paired samples have shapes {x.shape}, {y.shape} and {used.shape}, must be equal")
    used = used & np.isfinite(x) & np.isfinite(y)
    n = int(used.sum())
    return (float(y[used].mean() / x[used].mean()) if n and x[used].any() else float("nan")), n


def proportion(successes: int, n: int) -> tuple[float, float, float]:
    """Share and Wilson's 95 % interval of `successes` out of `n`."""
    if not 0 <= successes <= n or n == 0:
        raise ValueError(f"successes is {successes} of n {n}, must lie in 0..n with n >= 1")
    interval = stats.binomtest(successes, n).proportion_ci(0.95, "wilson")
    return successes / n, float(interval.low), float(interval.high)


@dataclass(frozen=True)
class PairedTest:
    """Wilcoxon's signed-rank test of paired differences b - a."""

    n: int
    difference: float
    """mean of b - a"""
    p: float
    """two-sided, exact; pairs without a difference are left out; 1 if all vanish, NaN for fewer than 2 pairs"""


def paired_test(a: ArrayLike, b: ArrayLike) -> PairedTest:
    """Tests values (n,) of two arms, paired by position; pairs with a NaN are left out."""
    x, y = np.asarray(a, float), np.asarray(b, float)
    if x.shape != y.shape:
        raise ValueError(f"paired samples have shapes {x.shape} and {y.shape}, must be equal")
    good = np.isfinite(x) & np.isfinite(y)
    difference = y[good] - x[good]
    n = len(difference)
    if n < 2:
        return PairedTest(n, float(difference.mean()) if n else float("nan"), float("nan"))
    if not difference.any():
        return PairedTest(n, 0.0, 1.0)
    return PairedTest(n, float(difference.mean()), _signed_rank_p(difference[difference != 0]))


def _signed_rank_p(difference: Array) -> float:
    """Two-sided p of Wilcoxon's statistic for differences (n,), none 0, over all 2^n signs.

    Counts of contacts are mostly ties and zeros. scipy takes a normal law for those from 14 pairs on, which calls three
    contacts in 20 pairs p = .08 where it is .25.
    """
    rank = np.rint(2 * stats.rankdata(np.abs(difference))).astype(int)  # tied ranks are halves
    share = np.ones(1)  # share[w]: of all signs, those whose positive ranks sum to w
    for r in rank:
        share = np.convolve(share, np.r_[0.5, np.zeros(r - 1), 0.5])
    off = np.abs(2 * np.arange(len(share)) - rank.sum())
    return float(min(1.0, share[off >= abs(2 * rank[difference > 0].sum() - rank.sum())].sum()))


def block_bootstrap(values: Array, blocks: NDArray[np.int_], seed: int, draws: int = 4000) -> tuple[Array, Array]:
    """95 % percentile intervals of the means of values (n, k) whose neighbours are correlated -> low (k,), high (k,).

    Whole blocks are drawn with replacement: blocks (n,) says which block a value belongs to. NaN for fewer than 2
    blocks. The same seed gives the same interval (blocks do not overlap: Carlstein 1986).
    """
    return _interval(*_drawn(values, blocks, seed, draws))


def block_bootstrap_ratio(
    values: Array, base: Array, blocks: NDArray[np.int_], seed: int, draws: int = 4000
) -> tuple[Array, Array]:
    """The same of the ratios of the means of values (n, k) to the mean of base (n,) > 0, paired."""
    both, _ = _drawn(np.column_stack([values, base]), blocks, seed, draws)
    return _interval(both[:, :-1], both[:, -1])


def _drawn(values: Array, blocks: NDArray[np.int_], seed: int, draws: int) -> tuple[Array, Array]:
    """Sums (draws, k) and sizes (draws,) of values in drawn blocks; no draws for fewer than 2 blocks."""
    x = np.asarray(values, float)
    if x.ndim != 2 or np.shape(blocks) != (len(x),):
        raise ValueError(f"values and blocks have shapes {x.shape} and {np.shape(blocks)}, must be (n, k) and (n,)")
    _, member = np.unique(blocks, return_inverse=True)
    count = int(member.max(initial=-1)) + 1
    if count < 2:
        return np.zeros((0, x.shape[1])), np.zeros(0)
    sums, sizes = np.zeros((count, x.shape[1])), np.bincount(member).astype(float)
    np.add.at(sums, member, x)
    drawn = np.random.default_rng(seed).multinomial(count, np.full(count, 1 / count), size=draws)
    return drawn @ sums, drawn @ sizes


def _interval(sums: Array, by: Array) -> tuple[Array, Array]:
    if not len(by):
        return np.full(sums.shape[1], np.nan), np.full(sums.shape[1], np.nan)
    low, high = np.percentile(sums / by[:, None], [2.5, 97.5], axis=0)
    return low, high


def paired_proportions_test(a: ArrayLike, b: ArrayLike) -> float:
    """McNemar's exact test of two paired yes/no samples (n,): two-sided p; 1 if no pair differs."""
    x, y = np.asarray(a, bool), np.asarray(b, bool)
    if x.shape != y.shape:
        raise ValueError(f"paired samples have shapes {x.shape} and {y.shape}, must be equal")
    gained, lost = int((~x & y).sum()), int((x & ~y).sum())
    return 1.0 if gained + lost == 0 else float(stats.binomtest(gained, gained + lost).pvalue)


def poisson_rate(events: int, n: int) -> tuple[float, float, float]:
    """Events a run and Garwood's exact 95 % interval of a Poisson rate, for `events` counted in `n` runs.

    It has an upper end also where nothing was counted. Too narrow if runs differ in their rates.
    """
    if events < 0 or n < 1:
        raise ValueError(f"events is {events} in n {n} runs, must be at least 0 in at least 1")
    low = float(stats.chi2.ppf(0.025, 2 * events)) / 2 if events else 0.0
    high = float(stats.chi2.ppf(0.975, 2 * events + 2)) / 2
    return events / n, low / n, high / n
