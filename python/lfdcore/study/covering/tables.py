"""Tables of study covering: success by object, RMSE by share observed, what the partner is worth, figures to reach."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from lfdcore.simulated.covering import CoveredObject, CoveringProtocol
from lfdcore.study.covering.study import (
    FORMS,
    METHODS,
    NOBODY,
    OWN,
    PARTNER_SHARES,
    SHARES,
    SHUFFLED,
    STRANGER,
    CoveringResult,
    CoveringTrial,
    DialRun,
)
from lfdcore.study.report.aims import Aim
from lfdcore.study.report.cells import figure_cell, mean_cell, p_cell, share_cell
from lfdcore.study.report.statistics import paired_test, summarise
from lfdcore.study.report.table import Row, Table

Floats = NDArray[np.float64]

LARGER = 0.95
"""[m]: objects at least as high are the larger ones (stepladder, raised cabinet, shelf)"""
SHOWN = (0.03, 0.1, 0.3, 0.5, 0.7, 1.0)
"""of SHARES, in tables"""
CAUGHT_UP = 1.15
"""IP has caught up where its RMSE is at most this times EaIP's (ERRATA Part 3 for the passing task)"""


def _share(found: Sequence[bool]) -> str:
    return share_cell(sum(found), len(found))


def _some(trials: Iterable[CoveringTrial], **wanted: object) -> list[CoveringTrial]:
    return [t for t in trials if all(getattr(t, name) == value for name, value in wanted.items())]


def _nearest(trials: Sequence[CoveringTrial]) -> str:
    distances = [100 * trial.whole.contact.distance for trial in trials]
    return f"{np.median(distances):.1f}\n>= {min(distances):.1f}"


def objects_table(result: CoveringResult, protocol: CoveringProtocol) -> Table:
    """A row an object: is it covered without a collision?"""
    trials = _some(result.trials, protocol=protocol.name, form="positions")
    rows: list[Row] = []
    for one in (*protocol.training, *protocol.novel):
        of_object = _some(trials, covered_object=one.name)
        cells = [f"{one.name}\n{_size(one)}", "novel" if one in protocol.novel else "known"]
        for method in METHODS:
            mine = _some(of_object, method=method)
            cells += [_share([t.whole.success for t in mine]), str(sum(t.whole.collided for t in mine)), _nearest(mine)]
        rows.append(tuple(cells))
    people, seeds = result.study.held_out, result.study.seeds
    heads = [f"{method} {what}" for method in METHODS for what in ("success", "collisions", "nearest [cm]")]
    return Table(
        f"Protocol {protocol.name}: covered without a collision, {protocol.observed:g} s of the partner observed",
        ("", "", *heads),
        tuple(rows),
        f"n = {people * seeds} an object: {people} unseen people x {seeds} seeds. Success: covered, and neither mouth "
        "nor gripper nearer than 2 cm. Interval: Wilson's 95 %; trials of a seed share a model, so it is somewhat too "
        "narrow. Nearest: median and least distance of the bag's mouth to the object. The arm's links are not in it. "
        + _uncovered_text(trials),
    )


def _uncovered_text(trials: Sequence[CoveringTrial]) -> str:
    """What went wrong without a collision: how often at which object, and an example."""
    missed: dict[tuple[str, str], list[str]] = {}
    for trial in trials:
        if not (trial.whole.success or trial.whole.collided):
            missed.setdefault((trial.method, trial.covered_object), []).append(trial.whole.reason)
    said = [f"{method} at the {name}, {len(why)} times: {why[0]}" for (method, name), why in missed.items()]
    return f"Not covered though nothing was touched: {'; '.join(said) if said else 'none'}."


def _size(one: CoveredObject) -> str:
    return f"{one.height:.2f} high, {one.width:.2f} wide [m]"


def forms_table(result: CoveringResult) -> Table:
    """What is observed x whole or executed motion, over all objects."""
    rows: list[Row] = []
    for protocol in result.study.protocols:
        for form in FORMS:
            for kind in ("whole", "executed"):
                trials = _some(result.trials, protocol=protocol.name, form=form)
                rows.append((f"{protocol.name}, {form}, {kind}", *_form_cells(result, protocol, form, kind, trials)))
    return Table(
        "What is observed of the partner, and which motion is judged: all objects",
        (
            "",
            *(f"{m} {what}" for m in METHODS for what in ("success", "collided")),
            "phase known",
            *(f"{m} noise" for m in METHODS),
        ),
        tuple(rows),
        "Positions: our default. Forcing: as printed (5.11, 5.12, and w_e after 5.16). Whole: the motion from the "
        "beginning, as it was inferred. Executed: from phase x* on, begun at rest where demonstrations begin on "
        "average (F14); where the phase is not known yet (5.5), from the beginning. Noise: what cross-validation "
        "chose for sigma^2, over the fit's residual, median and range over seeds; 10000 is the largest on offer.",
    )


def _form_cells(
    result: CoveringResult, protocol: CoveringProtocol, form: str, kind: str, trials: Sequence[CoveringTrial]
) -> list[str]:
    cells: list[str] = []
    for method in METHODS:
        verdicts = [getattr(t, kind) for t in _some(trials, method=method)]
        cells += [_share([v.success for v in verdicts]), _share([v.collided for v in verdicts])]
    cells.append(_share([t.determined for t in _some(trials, method="EaIP")]))
    for method in METHODS:
        factors = [run.factors[form, method] for run in result.of(protocol)]
        cells.append(f"{np.median(factors):.0f}\n{min(factors):.0f} - {max(factors):.0f}")
    return cells


def share_errors(result: CoveringResult, form: str, method: str, what: str) -> Floats:
    """(seeds, len(SHARES)) RMSE [m] of the second protocol, mean of all trials; what: to_final, to_demonstration."""
    runs = result.of(result.study.protocols[1])
    return np.array([getattr(run.errors[form, method], what).mean(axis=(0, 1)) for run in runs])


def shares_table(result: CoveringResult) -> Table:
    """Fig. 5.15b in figures."""
    rows: list[Row] = []
    for what, title in (("to_final", "final motion"), ("to_demonstration", "demonstration")):
        for form in FORMS:
            for method in METHODS:
                errors = 100 * share_errors(result, form, method, what)
                cells = [mean_cell(errors[:, SHARES.index(share)], 2, with_sd=False) for share in SHOWN]
                rows.append((f"{title}, {method}, {form}", *cells))
    return Table(
        f"RMSE [cm] of the left gripper's position by share observed, protocol 5.6.2 (n = {result.study.seeds} seeds)",
        ("to", *(f"{100 * share:.0f} %" for share in SHOWN)),
        tuple(rows),
        "At the same shares of both motions; mean of all objects and people, and Student's 95 % interval over seeds. "
        "3 %: at least 10 samples. " + _reached_text(result),
    )


def reached_at(errors: Floats, level: float) -> float:
    """The smallest of SHARES, interpolated, from which on errors (len(SHARES),) are first <= level; NaN if never."""
    below = np.flatnonzero(errors <= level)
    if not len(below):
        return float("nan")
    k = int(below[0])
    if k == 0:
        return SHARES[0]
    part = (errors[k - 1] - level) / (errors[k - 1] - errors[k])
    return float(SHARES[k - 1] + part * (SHARES[k] - SHARES[k - 1]))


def reached_shares(result: CoveringResult, what: str) -> Floats:
    """(seeds,) the share at which IP reaches EaIP's RMSE at 10 %; NaN if never."""
    levels = share_errors(result, "positions", "EaIP", what)[:, SHARES.index(0.1)]
    errors = share_errors(result, "positions", "IP", what)
    return np.array([reached_at(row, float(level)) for row, level in zip(errors, levels, strict=True)])


def _reached_text(result: CoveringResult) -> str:
    said = []
    for what, title in (("to_final", "final motion"), ("to_demonstration", "demonstration")):
        shares = reached_shares(result, what)
        good = shares[np.isfinite(shares)]
        when = f", at {100 * np.median(good):.0f} % in the median" if len(good) else ""
        said.append(f"to the {title} in {len(good)} of {len(shares)} seeds{when}")
    return f"IP reaches EaIP's RMSE at 10 % (positions): {'; '.join(said)} (thesis: nearly 70 %)."


def partner_table(result: CoveringResult) -> Table:
    """EaIP's RMSE beyond that with its own partner, paired over seeds."""
    rows: list[Row] = []
    for protocol in result.study.protocols:
        runs = result.of(protocol)
        own = 100 * np.array([run.partners[OWN] for run in runs])
        rows.append((f"{protocol.name}, {OWN}: RMSE", *(mean_cell(column, 2, with_sd=False) for column in own.T)))
        for partner in (NOBODY, STRANGER, SHUFFLED):
            other = 100 * np.array([run.partners[partner] for run in runs])
            rows.append((f"{protocol.name}, {partner}", *(_worse(a, b) for a, b in zip(own.T, other.T, strict=True))))
    return Table(
        f"What the partner's motion is worth to EaIP: RMSE to the demonstration [cm] (n = {result.study.seeds} seeds)",
        ("by share observed", *(f"{100 * share:.0f} %" for share in PARTNER_SHARES)),
        tuple(rows),
        "First row: with the own partner. Others: the difference to it, Student's 95 % interval, Wilcoxon's two-sided "
        "p. Another's partner: motions are permuted among the tests; learned from shuffled partners: among the "
        "demonstrations. Before 10 % the generator's partner shows almost nothing of the object.",
    )


def _worse(own: Floats, other: Floats) -> str:
    s = summarise(other - own)
    difference = figure_cell(s.mean, s.low, s.high, digits=2, sign="+")
    return difference if s.n < 2 else f"{difference}\np {p_cell(paired_test(own, other).p)}"


def dial_errors(result: CoveringResult, dial: float, personal: bool, method: str) -> Floats:
    """(seeds, len(PARTNER_SHARES)) RMSE [m] at a setting of the generator."""
    return np.array([run.errors[method] for run in _dials(result, dial, personal)])


def _dials(result: CoveringResult, dial: float, personal: bool) -> list[DialRun]:
    return [run for run in result.dials if (run.informative, run.personal) == (dial, personal)]


def dial_table(result: CoveringResult) -> Table:
    """Where does IP catch up?"""
    rows: list[Row] = []
    for personal in (True, False):
        for dial in result.study.dials:
            eaip, ip = (dial_errors(result, dial, personal, method) for method in METHODS)
            ratios = [mean_cell(column, 2, with_sd=False) for column in (ip / eaip).T]
            rows.append((f"informative {dial:g}{'' if personal else ', people alike'}", *ratios))
    return Table(
        f"IP's RMSE over EaIP's, by how informative the partner is (protocol 5.6.1, n = {result.study.seeds} seeds)",
        ("by share observed", *(f"{100 * share:.0f} %" for share in PARTNER_SHARES)),
        tuple(rows),
        "To the demonstration; mean of the seeds' ratios and Student's 95 % interval. 0: the partner moves the same "
        "for all objects; 1: follows the object as much as the robot does; the studies above are at .35. People alike: "
        f"they do not differ in reach and carry. {caught_up_text(result)}",
    )


def caught_up(result: CoveringResult, personal: bool, share: float) -> float:
    """The smallest dial at which IP's mean RMSE is within CAUGHT_UP times EaIP's; NaN if none."""
    k = PARTNER_SHARES.index(share)
    for dial in sorted(result.study.dials):
        eaip, ip = (dial_errors(result, dial, personal, method)[:, k].mean() for method in METHODS)
        if ip <= CAUGHT_UP * eaip:
            return dial
    return float("nan")


def caught_up_text(result: CoveringResult) -> str:
    """From which setting on IP is within 15 % of EaIP."""
    said = []
    for personal, people in ((True, "people who differ"), (False, "people alike")):
        for share in PARTNER_SHARES:
            dial = caught_up(result, personal, share)
            if np.isfinite(dial):
                said.append(f"{people}, {100 * share:.0f} % observed: from {dial:g}")
    return f"IP comes within {100 * (CAUGHT_UP - 1):.0f} % of EaIP: {'; '.join(said) if said else 'nowhere'}."


def aims(result: CoveringResult) -> list[Aim]:
    """What was to be reached."""
    return [*_success_aims(result), *_share_aims(result), *_partner_aims(result)]


def _success_aims(result: CoveringResult) -> list[Aim]:
    found = []
    for protocol in result.study.protocols:
        trials = _some(result.trials, protocol=protocol.name, form="positions")
        for novel, name in ((False, "known"), (True, "novel")):
            good = float(np.mean([t.whole.success for t in _some(trials, method="EaIP", novel=novel)]))
            found.append(Aim.between(1, 1, f"{protocol.name}: EaIP covers, {name} objects (share)", good, 3))
        for one in (*protocol.training, *protocol.novel):
            if one.height >= LARGER:
                mine = _some(trials, method="IP", covered_object=one.name)
                hit = float(np.mean([t.whole.collided for t in mine]))
                label = f"{protocol.name}: IP collides at the {one.name} (share)"
                found.append(Aim(label, "> .5", hit, 3, hit > 0.5))
    return found


def _share_aims(result: CoveringResult) -> list[Aim]:
    found = []
    for what, title in (("to_final", "final motion"), ("to_demonstration", "demonstration")):
        early = share_errors(result, "positions", "EaIP", what)[:, SHARES.index(0.1)].mean()
        late = share_errors(result, "positions", "IP", what)[:, SHARES.index(0.7)].mean()
        ratio = float(early / late)
        found.append(Aim.at_most(1, f"RMSE to the {title}: EaIP at 10 % over IP at 70 %", ratio, 2))
    return found


def _partner_aims(result: CoveringResult) -> list[Aim]:
    """Worse at the 5 % level with another's partner."""
    found = []
    runs = result.of(result.study.protocols[1])
    for k, share in enumerate(PARTNER_SHARES):
        own, other = (100 * np.array([run.partners[name][k] for run in runs]) for name in (OWN, STRANGER))
        test = paired_test(own, other)
        label = f"another's partner makes EaIP worse at {100 * share:.0f} % [cm]"
        found.append(Aim(label, "> 0, p < .05", test.difference, 2, test.difference > 0 and test.p < 0.05))
    return found
