"""Kernels of the action model: the same from one process, two, or a cluster; their likelihood on all samples."""

import dataclasses
from collections.abc import Iterator
from types import SimpleNamespace

import joblib
import numpy as np
import pytest
from distributed import Client, LocalCluster

from goal_worlds import GOALS, drives, samples_of
from lfdcore.estimation import ActionKernel
from lfdcore.study.goals.tables import likelihood_table
from lfdcore.training.goals import GoalLearningConfig, KernelLikelihood, fit_action_kernels, kernel_likelihoods

SAMPLES = samples_of(drives(1))
QUICK = GoalLearningConfig(search_samples=40, searches=2, generations=3)


def as_bytes(kernels: tuple[ActionKernel, ActionKernel]) -> list[bytes]:
    return [np.r_[k.amplitude, k.state_lengthscales, k.goal_lengthscales, k.noise].tobytes() for k in kernels]


@pytest.fixture(scope="module")
def alone() -> list[bytes]:
    return as_bytes(fit_action_kernels(SAMPLES, GOALS, QUICK))


@pytest.fixture
def cluster() -> Iterator[Client]:
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None) as workers,
        Client(workers) as client,
    ):
        yield client


def test_two_processes_find_the_kernels_of_one_to_the_byte(alone: list[bytes]) -> None:
    reported: list[tuple[str, int, int]] = []
    kernels = fit_action_kernels(SAMPLES, GOALS, QUICK, lambda *what: reported.append(what), processes=2)
    assert as_bytes(kernels) == alone
    assert reported == [("kernels", k, 4) for k in range(5)]


def test_a_cluster_of_two_workers_finds_the_kernels_of_one_process_to_the_byte(
    alone: list[bytes], cluster: Client
) -> None:
    with joblib.parallel_config("dask"):
        kernels = fit_action_kernels(SAMPLES, GOALS, QUICK, processes=2)
    assert as_bytes(kernels) == alone
    done = cluster.run(lambda dask_worker: dask_worker.state.executed_count)
    assert len(done) == 2
    assert sum(done.values()) > 0, "the search did not run on the cluster"


def test_each_axis_of_the_stick_has_its_own_kernel() -> None:
    quiet = dataclasses.replace(SAMPLES, joystick=SAMPLES.joystick * [1.0, 0.001])
    forward, left = fit_action_kernels(quiet, GOALS, QUICK)
    assert left.amplitude < 0.01 < forward.amplitude  # within ten times the root mean square of either
    assert left.noise < 0.001 < forward.noise


def test_another_seed_finds_other_kernels(alone: list[bytes]) -> None:
    assert as_bytes(fit_action_kernels(SAMPLES, GOALS, dataclasses.replace(QUICK, seed=2))) != alone


def test_likelihoods_of_kernels_are_c_3_of_the_draw_and_of_all_samples() -> None:
    kernels = (
        ActionKernel(0.6, [2.0, 2.0, 0.7, 0.7, 0.5, 0.5], [5.0, 6.0], 0.1),
        ActionKernel(0.5, [1.5, 2.0, 0.6, 0.8, 0.5, 0.7], [6.0, 4.0], 0.15),
    )
    yaw = SAMPLES.pose[:, 2]
    states = np.column_stack([SAMPLES.pose[:, :2], np.cos(yaw), np.sin(yaw), SAMPLES.twist])
    inputs = np.column_stack([states, GOALS.positions[SAMPLES.goal]])
    drawn = np.random.default_rng(QUICK.seed).permutation(len(SAMPLES))[:40]
    for axis, one in enumerate(kernel_likelihoods(SAMPLES, GOALS, kernels, QUICK)):
        assert (one.drawn, one.samples) == (40, len(SAMPLES))
        for found, chosen in ((one.of_drawn, drawn), (one.of_all, np.arange(len(SAMPLES)))):
            x = inputs[chosen] / np.r_[kernels[axis].state_lengthscales, kernels[axis].goal_lengthscales]
            K = kernels[axis].amplitude ** 2 * np.exp(-0.5 * ((x[:, None] - x[None]) ** 2).sum(2))
            K += kernels[axis].noise ** 2 * np.eye(len(x))
            y = SAMPLES.joystick[chosen, axis]
            fit = y @ np.linalg.solve(K, y) + np.linalg.slogdet(K)[1] + len(y) * np.log(2 * np.pi)
            assert found == pytest.approx(-0.5 * fit, rel=1e-9)


def test_the_report_shows_likelihoods_a_sample_and_none_without_the_model_of_all_data() -> None:
    both = (KernelLikelihood(400, 9000, 800.0, 27000.0), KernelLikelihood(400, 9000, -100.0, 900.0))
    table = likelihood_table(SimpleNamespace(likelihoods=both))
    assert table is not None
    assert table.rows == (("forward", "2.00", "3.00"), ("left", "-0.25", "0.10"))
    assert likelihood_table(SimpleNamespace(likelihoods=None)) is None
