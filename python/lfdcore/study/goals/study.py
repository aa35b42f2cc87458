"""Ch. 2 as one study: drives to destinations, models learned from five of six, judged on the sixth (Table 2.1, 2.2)."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from lfdcore.estimation import ActionModel
from lfdcore.geometry import Pose2, wrap_angle
from lfdcore.progress import StageProgress, silent
from lfdcore.simulated.courses import GoalWorld, goal_building, goals_in_map
from lfdcore.study.goals.drives import SEED, GoalDrives, noisy_joystick, perturbed_poses, record_goal_drives
from lfdcore.study.goals.evaluation import (
    BASELINES,
    Accuracy,
    accuracy,
    confidence_time,
)
from lfdcore.study.preset import Preset
from lfdcore.study.study import Option, Seed, Study
from lfdcore.training.goals import (
    GoalLearningConfig,
    KernelLikelihood,
    kernel_likelihoods,
    learn_goals,
    moving,
)
from lfdcore.wheelchair.goals.localisation import with_map_poses
from lfdcore.wheelchair.goals.model import GoalModel
from lfdcore.wheelchair.goals.network import smoothed_over_time
from lfdcore.wheelchair.goals.samples import GoalSamples, drive_samples, goal_samples
from lfdcore.wheelchair.goals.track import BeliefTrack, track_beliefs

Floats = NDArray[np.float64]
NOISE = (0.0, 5.0, 10.0, 15.0, 20.0, 25.0)
"""Of the stick in Table 2.1 [% of full scale]"""
TRIALS, TRIAL_GOALS, TRIAL_SEED = 5, 4, 500
"""Drivers and destinations of Table 2.1; their drives have the study's seed and this more"""
FILTERED = 2.0
"""[s] time constant of Table 2.1's second share"""
POSE_ERRORS = ((0.0, 0.0), (0.1, 0.0), (0.3, 0.0), (1.0, 0.0), (0.0, 5.0), (0.0, 20.0))
"""[m], [degrees] by which a localiser may be off all along a drive"""
_TIMED = 20
"""updates whose median is a method's time"""


@dataclass(frozen=True, kw_only=True)
class GoalStudy(Study):
    """Drives to six destinations -> network, Gaussian process and filter: Tables 2.1-2.2, Fig. 2.4-2.8. Needs torch."""

    name = "goals"
    title = "global goals"

    map_file: Annotated[
        Path | None, Option("A map (.yaml) with destinations drawn by seed. Default: our building.", flag="--map")
    ] = None
    full: Annotated[bool, Option("Judge all data too: minutes, and 2 GB for N = 10^4.", flag="--full/--sparse")] = True
    subset: Annotated[int, Option("Samples that Alg. 1 keeps.", minimum=1)] = GoalLearningConfig.subset
    preset: Annotated[Preset, Option("'thesis' restores printed values.")] = Preset.default
    seed: Seed = SEED

    def world(self) -> GoalWorld:
        """Of the map; without one the building of Ch. 2."""
        return goal_building() if self.map_file is None else goals_in_map(self.map_file, self.seed)

    def learning(self) -> GoalLearningConfig:
        """Of the preset, with the study's subset and seed."""
        config = GoalLearningConfig.thesis() if Preset(self.preset) is Preset.thesis else GoalLearningConfig()
        return replace(config, subset=self.subset, seed=self.seed)


@dataclass(frozen=True)
class NoiseTrial:
    """When the network was 90 % sure of where a drive went."""

    goal: int
    driver: int
    noise: float
    """[% of full scale]"""
    sure_after: float
    """[s]; NaN if never"""
    filtered: float
    """[s] the same of its estimates filtered over FILTERED seconds (end of Sec. 2.2)"""
    duration: float
    """[s] of the drive"""


@dataclass(frozen=True)
class PoseError:
    """How often the sparse model is right where poses are off."""

    label: str
    accuracy: Accuracy


@dataclass(frozen=True)
class GoalResult:
    """Everything the report shows, of the held-out drives where nothing else is said."""

    study: GoalStudy
    drives: GoalDrives
    model: GoalModel
    held_out: GoalSamples
    tracks: dict[str, BeliefTrack]
    """'sparse', 'full' (if asked for), and both again with ', no process noise'"""
    network: Floats
    """(N, L) the network's likelihoods"""
    accuracies: tuple[Accuracy, ...]
    trials: tuple[NoiseTrial, ...]
    pose_errors: tuple[PoseError, ...]
    matcher_errors: Floats
    """(M, 2) [m], [rad] of the scan matcher's poses at the held-out drives' scans"""
    likelihoods: tuple[KernelLikelihood, KernelLikelihood] | None
    """of the action kernels, forward and left; None where all data were not judged"""
    update_seconds: dict[str, float]
    """median of a belief's update"""

    @property
    def truth(self) -> Floats:
        """(N, 2) [m, map] the destination of each held-out sample."""
        return self.model.goals.positions[self.held_out.goal]


def run_goal_study(study: GoalStudy, folder: Path, tell: StageProgress = silent) -> GoalResult:
    """Drives, with logs in `folder`, learns, judges. ValueError as goals_in_map and learn_goals; needs torch."""
    import torch  # noqa: F401 - where it is missing, before anything is driven

    world = study.world()
    drives = record_goal_drives(folder, world, study.seed, processes=study.processes, progress=partial(tell, "drive"))
    trials = _record_trials(study, world, folder / "trials", tell)
    return judge_goal_drives(study, drives, trials, study.learning(), tell)


def judge_goal_drives(
    study: GoalStudy, drives: GoalDrives, trials: GoalDrives, learning: GoalLearningConfig, tell: StageProgress = silent
) -> GoalResult:
    """Learns from recorded drives and judges on those held out; trials: drives of others, for Table 2.1."""
    goals = drives.world.goals
    model = learn_goals(drives.logs(drives.training), goals, learning, tell, study.processes or 1)
    held_out = goal_samples(drives.logs(drives.held_out), goals)
    likelihoods = kernel_likelihoods(model.samples, goals, model.kernels, learning, tell) if study.full else None
    models = action_models(model, study.full, tell)
    tracks = _tracks(model, models, held_out, tell)
    network = model.network.predict(held_out.pose, held_out.joystick)
    off, localised = _localised(drives, tell)
    return GoalResult(
        study,
        drives,
        model,
        held_out,
        tracks,
        network,
        _accuracies(model, held_out, tracks, network),
        _noise_trials(study, trials, model),
        (*_pose_errors(model, models["sparse"], held_out, tell), _matched(model, models["sparse"], localised)),
        off,
        likelihoods,
        {name: _seconds(model, one, held_out) for name, one in models.items()},
    )


def action_models(model: GoalModel, full: bool, tell: StageProgress) -> dict[str, ActionModel]:
    """'sparse' and, if asked for, 'full'."""
    names: tuple[str, ...] = ("sparse", "full") if full else ("sparse",)
    found = {}
    for k, name in enumerate(names):
        tell("prepare models", k, len(names))
        found[name] = model.action_model("full" if name == "full" else "sparse")
    tell("prepare models", len(names), len(names))
    return found


def _tracks(
    model: GoalModel, models: dict[str, ActionModel], held_out: GoalSamples, tell: StageProgress
) -> dict[str, BeliefTrack]:
    without = replace(model, config=replace(model.config, process_noise=0.0))
    tracks = {}
    for name, one in models.items():
        for label, how in ((name, model), (f"{name}, no process noise", without)):
            tracks[label] = track_beliefs(how, held_out, one, partial(tell, label))
    return tracks


def _accuracies(
    model: GoalModel, held_out: GoalSamples, tracks: dict[str, BeliefTrack], network: Floats
) -> tuple[Accuracy, ...]:
    said = {f"Gaussian process, {name}": track.nearest for name, track in tracks.items()}
    said["network"] = network.argmax(axis=1)
    said |= {name: baseline(model, held_out) for name, baseline in BASELINES.items()}
    return tuple(accuracy(name, goals, held_out) for name, goals in said.items())


def _record_trials(study: GoalStudy, world: GoalWorld, folder: Path, tell: StageProgress) -> GoalDrives:
    folder.mkdir(exist_ok=True)
    return record_goal_drives(
        folder, world, study.seed + TRIAL_SEED, processes=study.processes, progress=partial(tell, "drive with noise")
    )


def _noise_trials(study: GoalStudy, drives: GoalDrives, model: GoalModel) -> tuple[NoiseTrial, ...]:
    """Five drivers to the first destinations; the noise comes onto the recorded stick, the chair was driven without."""
    trials = []
    for k, (name, driver) in enumerate(zip(drives.destinations, drives.drivers, strict=True)):
        goal = drives.world.goals.index(name)
        if goal >= TRIAL_GOALS or driver >= TRIALS:
            continue
        samples = drive_samples(drives.logs([k])[0], goal)
        for noise in NOISE:
            stick = noisy_joystick(samples.joystick, noise, study.seed + TRIAL_SEED + k)
            said = model.network.predict(samples.pose, stick)
            filtered = smoothed_over_time(said, drives.traces[k].period, FILTERED)
            sure, later = (confidence_time(one, samples.stamp, goal) for one in (said, filtered))
            trials.append(NoiseTrial(goal, driver, noise, sure, later, float(samples.stamp[-1])))
    return tuple(sorted(trials, key=lambda trial: (trial.goal, trial.noise, trial.driver)))


def _pose_errors(model: GoalModel, sparse: ActionModel, held_out: GoalSamples, tell: StageProgress) -> list[PoseError]:
    found = []
    for k, (metres, degrees) in enumerate(POSE_ERRORS):
        tell("poses that are off", k, len(POSE_ERRORS))
        poses = held_out.pose.copy()
        for drive in np.unique(held_out.drive):
            mine = held_out.drive == drive
            poses[mine] = perturbed_poses(poses[mine], metres, float(np.radians(degrees)), int(drive))
        off = replace(held_out, pose=poses)
        label = f"{metres:g} m" if metres or not degrees else f"{degrees:g} degrees"
        nearest = track_beliefs(model, off, sparse).nearest
        found.append(PoseError(label, accuracy(label, nearest, held_out)))
    tell("poses that are off", len(POSE_ERRORS), len(POSE_ERRORS))
    return found


def _localised(drives: GoalDrives, tell: StageProgress) -> tuple[Floats, list[GoalSamples]]:
    """The held-out drives as if their poses in the map were not known -> errors (M, 2), samples with matched poses."""
    errors, samples = [], []
    logs = drives.logs(drives.held_out)
    for k, log in enumerate(logs):
        tell("match scans", k, len(logs))
        truth = log.map_pose_at(log.scan_stamp)
        blind = replace(log, map_stamp=np.zeros(0), map_odom=np.zeros((0, 3)))
        matched = with_map_poses(blind, drives.world.grid, Pose2(*truth[0].tolist()))
        off = matched.map_pose_at(log.scan_stamp) - truth
        errors.append(np.column_stack([np.hypot(off[:, 0], off[:, 1]), np.abs(wrap_angle(off[:, 2]))]))
        samples.append(drive_samples(matched, drives.world.goals.index(log.metadata["destination"]), k))
    tell("match scans", len(logs), len(logs))
    return np.concatenate(errors), samples


def _matched(model: GoalModel, sparse: ActionModel, drives: Sequence[GoalSamples]) -> PoseError:
    joined = {name: np.concatenate([getattr(d, name) for d in drives]) for name in GoalSamples.__dataclass_fields__}
    samples = GoalSamples(**joined)
    return PoseError("by the scan matcher", accuracy("matched", track_beliefs(model, samples, sparse).nearest, samples))


def _seconds(model: GoalModel, action_model: ActionModel, held_out: GoalSamples) -> float:
    """Median seconds of one belief's update, on one thread."""
    asked = moving(held_out, model.config.at_rest)  # at rest nothing is computed
    chosen = asked.where(np.arange(min(_TIMED, len(asked))))
    taken = []
    for k in range(len(chosen)):
        one = chosen.where(np.array([k]))
        begin = time.perf_counter()
        track_beliefs(model, one, action_model)
        taken.append(time.perf_counter() - begin)
    return float(np.median(taken))
