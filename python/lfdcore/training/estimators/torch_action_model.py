"""The action model over all samples (Sec. 2.3) in torch, for those who have a GPU: the numbers of the C++ ActionModel.

Batched float64, no loop over samples. Like C++ it sums over pairs of goals where samples share them (docs/theory.md);
else, or if asked to, over pairs of samples, as the equations are printed, with Q_ab by outer sums of precomputed terms.
D is kept whole: 8 N^2 bytes an action. On a CPU both are slower than C++ (benchmarks/bench_action_model.py).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray

from lfdcore.estimation import ActionKernel, ActionMoments, Belief
from lfdcore.wheelchair.goals.model import GoalModel

Floats = NDArray[np.float64]


class TorchActionModel:
    """As lfdcore.estimation.ActionModel without a subset; what depends on neither state nor belief is made once."""

    def __init__(
        self,
        states: ArrayLike,
        goals: ArrayLike,
        actions: ArrayLike,
        kernels: Sequence[ActionKernel],
        device: str = "cuda",
        *,
        share_goals: bool = True,
    ) -> None:
        """States (N, Dx), goals (N, Dg) [m], actions (N, Da), a kernel for every action; device as torch names it;
        share_goals: sum over pairs of goals where they are few (8 N >= L^2), else over pairs of samples. ValueError
        where torch finds no such device, for data that do not fit or are not finite, and a covariance that is not
        positive definite."""
        self.device = _device(device)
        self.kernels = tuple(kernels)
        x, g, y = (np.array(part, float) for part in (states, goals, actions))
        _require_fitting(x, g, y, self.kernels)
        self._states, self._goals = self._tensor(x), self._tensor(g)
        self._scales = [self._tensor(kernel.state_lengthscales) for kernel in kernels]
        self._H = [self._tensor(kernel.goal_lengthscales) ** 2 for kernel in kernels]
        self._inverse, self._beta = [], []
        for a, kernel in enumerate(kernels):
            inverse, beta = self._conditioned(a, kernel, self._tensor(y[:, [a]]))
            self._inverse.append(inverse)
            self._beta.append(beta)
        places, numbers = np.unique(g, axis=0, return_inverse=True)
        self._number = None
        if share_goals and len(places) ** 2 <= 8 * len(g):
            self._goals, self._number = self._tensor(places), torch.from_numpy(numbers.reshape(-1, 1)).to(self.device)

    def __len__(self) -> int:
        return len(self._states)

    @property
    def nbytes(self) -> int:
        """Memory held between updates, on the device."""
        held = [self._states, self._goals, *self._inverse, *self._beta]
        return sum(tensor.element_size() * tensor.nelement() for tensor in held)

    def intention_filter(
        self, mean: ArrayLike, covariance: ArrayLike, process_noise: float = 0.0
    ) -> TorchIntentionFilter:
        """What GoalFilter asks of a model that is not the C++ one."""
        return TorchIntentionFilter(self, mean, covariance, process_noise)

    def moments(self, state: ArrayLike, mean: ArrayLike, covariance: ArrayLike) -> ActionMoments:
        """Exact moments at state (Dx,) for a goal ~ N(mean (Dg,), covariance (Dg, Dg)). ValueError for other sizes and
        what is not finite."""
        given = [np.array(part, float) for part in (state, mean, covariance)]
        goal_dims = self._goals.shape[1]
        sizes = ((self._states.shape[1],), (goal_dims,), (goal_dims, goal_dims))
        for name, part, size in zip(("state", "mean", "covariance"), given, sizes, strict=True):
            if part.shape != size or not np.isfinite(part).all():
                raise ValueError(f"{name} must be {size} finite numbers, is {part.tolist()}")
        x, mu, sigma = map(self._tensor, given)
        u = self._goals - mu
        near = [torch.exp(-0.5 * ((self._states - x) / scale).square().sum(1)) for scale in self._scales]
        if self._number is not None:  # (N, L): a sample's similarity in its goal's column
            empty = near[0].new_zeros(len(self), len(u))
            near = [empty.scatter(1, self._number, k[:, None]) for k in near]
        pulled = [k.T @ beta if k.ndim == 2 else k * beta for k, beta in zip(near, self._beta, strict=True)]
        count = len(self.kernels)
        firsts = [self._first(a, u, sigma, pulled[a]) for a in range(count)]
        m, C = (torch.stack(part).cpu().numpy() for part in zip(*firsts, strict=True))
        G = np.empty((count, count))
        for a in range(count):
            for b in range(a + 1):
                G[a, b] = G[b, a] = self._second(a, b, u, sigma, near[a], pulled[a], pulled[b]) - m[a] * m[b]
        return ActionMoments(m, G, C.T)

    def _tensor(self, values: ArrayLike) -> torch.Tensor:
        return torch.tensor(np.asarray(values), dtype=torch.float64, device=self.device)

    def _conditioned(self, a: int, kernel: ActionKernel, y: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """D = (K + s^2 I)^-1 and beta = D y (ERRATA 1)"""
        joint = torch.cat([self._states / self._scales[a], self._goals / self._H[a].sqrt()], 1)
        K = torch.cdist(joint, joint, compute_mode="donot_use_mm_for_euclid_dist").square_().mul_(-0.5).exp_()
        K.mul_(kernel.amplitude**2).diagonal().add_(kernel.noise**2)
        factor, failed = torch.linalg.cholesky_ex(K)
        del K
        if int(failed):
            raise ValueError("the covariance of the samples is not positive definite: raise a kernel's noise")
        inverse = torch.cholesky_inverse(factor).T  # symmetric; its rows lie together now, as those of Q do
        return inverse, torch.cholesky_solve(y, factor)[:, 0]

    def _first(
        self, a: int, u: torch.Tensor, sigma: torch.Tensor, pulled: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """m_a and C_a (ERRATA 4)"""
        wide = sigma + torch.diag(self._H[a])
        solved = torch.linalg.solve(wide, u.T).T
        scale = self.kernels[a].amplitude ** 2 * torch.sqrt(self._H[a].prod() / torch.det(wide))
        q = scale * torch.exp(-0.5 * (u * solved).sum(1)) * pulled
        return q.sum(), sigma @ (solved.T @ q)

    def _second(
        self,
        a: int,
        b: int,
        u: torch.Tensor,
        sigma: torch.Tensor,
        near: torch.Tensor,
        first: torch.Tensor,
        second: torch.Tensor,
    ) -> float:
        """beta_a'Q_ab beta_b, and for a = b with a^2 - Tr(D Q_aa) + s^2 (ERRATA 2)"""
        Ha, Hb = self._H[a], self._H[b]
        total = Ha + Hb
        R = sigma + torch.diag(Ha * Hb / total)
        left, right = u * Hb / total, u * Ha / total
        inverse = torch.linalg.inv(R)
        own = -0.5 * (u.square() / total).sum(1)
        Q = (u / total) @ u.T  # the exponent expanded: one product of (N, Dg) matrices
        Q.addmm_(left @ inverse, right.T, alpha=-1.0)
        Q += (own - 0.5 * (left @ inverse * left).sum(1))[:, None]
        Q += own - 0.5 * (right @ inverse * right).sum(1)
        Q.exp_()
        one, other = self.kernels[a], self.kernels[b]
        scale = (one.amplitude * other.amplitude) ** 2 * torch.sqrt((Ha * Hb / total).prod() / torch.det(R))
        weighted = scale * torch.dot(first, Q @ second)
        if a != b:
            return float(weighted)
        D = self._inverse[a]
        traced = torch.sum(Q * (near.T @ (D @ near))) if near.ndim == 2 else torch.dot(near, Q.mul_(D) @ near)
        return float(weighted - scale * traced) + one.amplitude**2 + one.noise**2


class TorchIntentionFilter:
    """2.2-2.3 as lfdcore.estimation.IntentionFilter."""

    def __init__(
        self, model: TorchActionModel, mean: ArrayLike, covariance: ArrayLike, process_noise: float = 0.0
    ) -> None:
        if not 0 <= process_noise < np.inf:
            raise ValueError(f"process_noise is {process_noise} m^2, must be >= 0 and finite")
        self.model, self.process_noise = model, process_noise
        self._prior = self._belief = Belief(np.asarray(mean, float), np.asarray(covariance, float))

    @property
    def belief(self) -> Belief:
        """As of the last update; before the first, the prior."""
        return self._belief

    def reset(self) -> None:
        """Back to the prior."""
        self._belief = self._prior

    def update(self, state: ArrayLike, action: ArrayLike) -> Belief:
        """The action (Da,) taken at state (Dx,) -> the new belief. ValueError, and the belief stays as it was, for
        other sizes, for what is not finite and if the action's covariance is singular."""
        wider = self._belief.widened(self._prior, self.process_noise)
        self._belief = wider.conditioned(self.model.moments(state, wider.mean, wider.covariance), action)
        return self._belief


def full_action_model(model: GoalModel, device: str) -> TorchActionModel:
    """Of all samples that a model of destinations was learned from. ValueError as TorchActionModel."""
    return TorchActionModel(*model.action_samples(), model.kernels, device)


def _device(name: str) -> torch.device:
    try:
        torch.empty(0, device=name)
    except (RuntimeError, AssertionError) as refused:  # no CUDA driver, or torch built without it
        reason = str(refused).strip().splitlines()[0]
        raise ValueError(
            f"device {name!r} is not there, 'cpu' always is; torch {torch.__version__}: {reason}"
        ) from None
    return torch.device(name)


def _require_fitting(states: Floats, goals: Floats, actions: Floats, kernels: Sequence[ActionKernel]) -> None:
    shapes = [part.shape for part in (states, goals, actions)]
    if any(len(shape) != 2 or shape[0] != len(states) for shape in shapes) or not len(states):
        raise ValueError(f"states, goals and actions must be (N, D) of the same N > 0, are {shapes}")
    if not all(np.isfinite(part).all() for part in (states, goals, actions)):
        raise ValueError("states, goals and actions must be finite")
    if len(kernels) != actions.shape[1]:
        raise ValueError(f"{actions.shape[1]} actions need as many kernels, not {len(kernels)}")
    for kernel in kernels:
        if (len(kernel.state_lengthscales), len(kernel.goal_lengthscales)) != (states.shape[1], goals.shape[1]):
            raise ValueError(f"a kernel's length-scales must fit states and goals of shape {shapes[0]}, {shapes[1]}")
