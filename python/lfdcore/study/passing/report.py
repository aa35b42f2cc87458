"""The report of study passing: claims, distances and shares of passing paths by observed length, Fig. 5.5-5.7."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfdcore.pictures.style import Picture
from lfdcore.progress import StageProgress
from lfdcore.simulated.passing import NOVEL, STEPS, TRAINING
from lfdcore.study.passing.pictures import demonstrations_figure, distance_figure, observations_figure
from lfdcore.study.passing.study import (
    ARMS,
    AXES,
    GROUPS,
    Group,
    PassingExample,
    PassingResult,
    PassingStudy,
    run_passing_study,
)
from lfdcore.study.report.aims import Aim, reached_of
from lfdcore.study.report.cells import mean_cell
from lfdcore.study.report.page import Section
from lfdcore.study.report.statistics import block_bootstrap_ratio, summarise, summarise_bounded
from lfdcore.study.report.table import Row, Table
from lfdcore.study.study import Findings

Floats = NDArray[np.float64]
TITLE = "Passing over a rectangle (Sec. 5.5)"
FORMS = {"": "positions", ", phase given": "phase given", ", printed": "as printed"}
"""Ends of the arms' names, and what they stand for."""
BOTH, _ = AXES
FEW, MANY = 40, 100
"""samples: up to so many little is observed, from so many on much"""


# -- figures to reach -----------------------------------------------------------------------------------------------


def claims(result: PassingResult, form: str = "") -> list[Aim]:
    """The four of ERRATA Part 3 on novel rectangles, of the arms whose names end in `form` (FORMS)."""
    lengths = np.array(result.study.lengths)
    ip, eaip, ip_x, eaip_x = (
        result.by_seed(result.distance, arm + form, seen, "novel") for seen in AXES for arm in ("IP", "EaIP")
    )
    few, many = lengths <= FEW, lengths >= MANY
    begin, end = lengths == 0, lengths == STEPS
    return [
        _worst(f"1. little is observed (L <= {FEW}): EaIP / IP", -np.inf, 0.6, eaip, ip, lengths, few),
        _worst(f"2. both axes, L >= {MANY}: IP / EaIP", 0.85, 1.15, ip, eaip, lengths, many),
        _fixed(f"3. horizontal only: IP at L = {STEPS} / at L = 0", 0.9, np.inf, ip_x[:, end], ip_x[:, begin]),
        _worst("... EaIP / IP, at every L", -np.inf, 0.6, eaip_x, ip_x, lengths, lengths >= 0),
        _fixed(f"4. EaIP at L = 0 / at L = {STEPS}", -np.inf, 1.6, eaip[:, begin], eaip[:, end]),
    ]


def _worst(
    label: str,
    least: float,
    most: float,
    above: Floats,
    below: Floats,
    lengths: NDArray[np.int_],
    where: NDArray[np.bool_],
) -> Aim:
    """Of the lengths chosen, that whose ratio of means is furthest up, or furthest from 1 where it has two bounds."""
    ratios = above.mean(axis=0) / below.mean(axis=0)
    badness = np.abs(ratios - 1) if np.isfinite(least) else ratios
    k = int(np.argmax(np.where(where, badness, -np.inf)))
    return _fixed(label, least, most, above[:, k], below[:, k], f"at L = {lengths[k]}")


def _fixed(label: str, least: float, most: float, above: Floats, below: Floats, note: str = "") -> Aim:
    above, below = above.ravel(), below.ravel()
    found = float(above.mean() / below.mean())
    low, high = block_bootstrap_ratio(above[:, None], below, np.arange(len(above)), seed=1)
    return Aim.between(least, most, label, found, 2, low=float(low[0]), high=float(high[0]), note=note)


def claims_table(result: PassingResult) -> Table:
    """Figures to reach, and the same of the other forms."""
    by_form = [claims(result, form) for form in FORMS]
    rows = tuple((of[0].label, of[0].wanted, *(one.as_text() for one in of)) for of in zip(*by_form, strict=True))
    return Table(
        f"Figures to reach, novel rectangles ({_origin(result)})",
        ("ratio of mean DTW distances", "wanted", *FORMS.values()),
        rows,
        "Of several L, the one nearest to failing. In brackets: 95 % percentiles of a bootstrap over seeds. "
        f"{_cases(result)} Positions: the partner's positions are observed and the phase is the likeliest; this "
        "is what is to be reached. Phase given: the same with known phases. As printed: forcing functions are "
        "observed (5.11, 5.12) and e weighs as printed after 5.16.",
    )


def _cases(result: PassingResult) -> str:
    """How often claim 1's direction holds one by one."""
    few = np.array(result.study.lengths) <= FEW
    novel = result.distance[:, :, 0, :, len(TRAINING) :][:, :, few].mean(axis=-1)
    ip, eaip = novel[:, 0], novel[:, 1]
    share = 100 * (eaip < ip).mean()
    return f"Case by case (seed, rectangle, L <= {FEW}): EaIP is nearer in {share:.0f} % of {ip.size}."


def _origin(result: PassingResult) -> str:
    study = result.study
    last = study.seed + study.seeds - 1
    return f"n = {study.seeds} seeds, {study.seed}..{last}" if study.seeds > 1 else f"n = 1 seed, {last}"


# -- by observed length ---------------------------------------------------------------------------------------------


def distance_table(result: PassingResult) -> Table:
    """Fig. 5.7 in figures."""
    rows = [
        (f"{group}, {seen}, {arm}", *_means(result.by_seed(result.distance, arm, seen, group)))
        for group in reversed(GROUPS)
        for seen in AXES
        for arm in ("IP", "EaIP")
    ]
    return Table(
        f"DTW distance to demonstrations [px per sample] by L, samples observed ({_origin(result)})",
        _header(result),
        tuple(rows),
        f"Of means over {len(NOVEL)} rectangles and {result.study.demonstrations} people who are observed; below: "
        "95 % interval over seeds (Student's). Floor, two people's demonstrations of one rectangle: "
        f"{_floors(result)}. "
        "A mean path may be nearer than the floor: it has no one's tremor and habits. Noise by cross-validation, over "
        f"the fit's residual: {_factors(result)}.",
    )


def _header(result: PassingResult) -> Row:
    return ("", *(f"L = {length}" for length in result.study.lengths))


def _means(by_seed: Floats) -> list[str]:
    """A cell a length."""
    return [mean_cell(column, 2, with_sd=False) for column in by_seed.T]


def _floors(result: PassingResult) -> str:
    parts = []
    for group in reversed(GROUPS):
        s = summarise(result.floor_by_seed(group))
        parts.append(f"{group} {s.mean:.2f}" + (f" [{s.low:.2f}, {s.high:.2f}]" if s.n > 1 else ""))
    return ", ".join(parts)


def _factors(result: PassingResult) -> str:
    """Of arms that estimate the phase: those that know it have the same model."""
    each = [(arm.name, result.factor[:, k]) for k, arm in enumerate(ARMS) if not arm.phase_known]
    return "; ".join(f"{name} {column.min():g} - {column.max():g}" for name, column in each)


def forms_table(result: PassingResult) -> Table:
    """What the phase's estimate costs, and the thesis's form."""
    rows = [
        (f"{seen}, {arm}{form}", *_means(result.by_seed(result.distance, arm + form, seen, "novel")))
        for seen in AXES
        for arm in ("IP", "EaIP")
        for form in FORMS
    ]
    return Table(
        "DTW distance [px per sample], novel rectangles: the phase known, and forcing functions as printed",
        _header(result),
        tuple(rows),
        "An estimated phase stalls where a person stops short of the mean motion's end. Then all that was seen is "
        "taken for a part, and the completed motion goes on.",
    )


def own_table(result: PassingResult) -> Table:
    """How near to what the person who is observed did."""
    rows = [
        (f"{seen}, {arm}{form}", *_means(result.by_seed(result.own, arm + form, seen, "novel")))
        for seen in AXES
        for arm in ("IP", "EaIP")
        for form in ("", ", phase given")
    ]
    return Table(
        "DTW distance [px per sample] to what the observed person did, novel rectangles",
        _header(result),
        tuple(rows),
        "The error of the prediction itself, where the person's own habits count too.",
    )


def passed_table(result: PassingResult) -> Table:
    """Shares of paths over the rectangle that do not touch it."""
    rows = [
        (f"{group}, {seen}, {arm}", *_shares(result.by_seed(result.passed, arm, seen, group)))
        for group in reversed(GROUPS)
        for seen in AXES
        for arm in ("IP", "EaIP", "IP, printed", "EaIP, printed")
    ]
    each = result.study.demonstrations * len(NOVEL)
    return Table(
        f"Share of mean paths that pass the rectangle without touching it [%] ({_origin(result)}, {each} paths each)",
        _header(result),
        tuple(rows),
        "Below, where seeds differ: 95 % percentiles of a bootstrap over seeds.",
    )


def _shares(by_seed: Floats) -> list[str]:
    cells = []
    for s in (summarise_bounded(100 * column) for column in by_seed.T):
        differ = s.n > 1 and s.high > s.low
        cells.append(f"{s.mean:.0f}" + (f"\n[{s.low:.0f}, {s.high:.0f}]" if differ else ""))
    return cells


def passing_tables(result: PassingResult) -> list[Table]:
    """All tables, figures to reach first."""
    return [make(result) for make in (claims_table, distance_table, forms_table, passed_table, own_table)]


# -- the report -----------------------------------------------------------------------------------------------------


def passing_headline(result: PassingResult) -> str:
    """The result in two sentences."""
    ip, eaip = (result.by_seed(result.distance, arm, BOTH, "novel")[:, 0].mean() for arm in ("IP", "EaIP"))
    return (
        f"Novel rectangles, nothing of the partner seen: DTW distance to demonstrations EaIP {eaip:.1f}, IP {ip:.1f} "
        f"px per sample (two demonstrations: {result.floor_by_seed('novel').mean():.1f}); {_origin(result)}. "
        f"{reached_of(claims(result))}"
    )


def figure_rows(result: PassingResult) -> list[dict[str, Any]]:
    """All figures for machines: a row an arm, what is seen, kind of rectangle and L; floors; claims; then the first
    kind again for every seed."""
    rows = [
        _row(result, arm.name, seen, group, k, length)
        for arm in ARMS
        for seen in AXES
        for group in GROUPS
        for k, length in enumerate(result.study.lengths)
    ]
    for group in GROUPS:
        s = summarise(result.floor_by_seed(group))
        rows.append({"floor": group, "n": s.n, "distance": s.mean, "low": s.low, "high": s.high})
    for form, title in FORMS.items():
        rows += [{"form": title, **one.as_row()} for one in claims(result, form)]
    return rows + _rows_by_seed(result)


def _rows_by_seed(result: PassingResult) -> list[dict[str, Any]]:
    values: dict[str, Floats | NDArray[np.bool_]] = {
        "distance": result.distance,
        "distance_to_own": result.own,
        "passed": result.passed,
    }
    rows = []
    for arm, seen, group in product([arm.name for arm in ARMS], AXES, GROUPS):
        by_seed = {name: result.by_seed(array, arm, seen, group) for name, array in values.items()}
        for s, k in np.ndindex(result.study.seeds, len(result.study.lengths)):
            what = {"arm": arm, "seen": seen, "rectangles": group, "observed": result.study.lengths[k]}
            seed = {"seed": result.study.seed + s}
            rows.append(what | seed | {name: float(array[s, k]) for name, array in by_seed.items()})
    return rows


def _row(result: PassingResult, arm: str, seen: str, group: Group, k: int, length: int) -> dict[str, Any]:
    distance, own, passed = (
        summarise(result.by_seed(values, arm, seen, group)[:, k])
        for values in (result.distance, result.own, result.passed)
    )
    said = {"arm": arm, "seen": seen, "rectangles": group, "observed": length, "n": distance.n}
    own_said = {"distance_to_own": own.mean, "own_low": own.low, "own_high": own.high}
    return {
        **said,
        "distance": distance.mean,
        "low": distance.low,
        "high": distance.high,
        **own_said,
        "passed": passed.mean,
    }


def _pictures(result: PassingResult, example: PassingExample) -> list[Picture]:
    of_seed = f"Seed {example.seed}."
    return [
        Picture(
            demonstrations_figure(example),
            f"As Fig. 5.5: demonstrations that are learned from, and motions drawn from p(theta | e). {of_seed}",
            "demonstrations.png",
        ),
        Picture(
            observations_figure(example),
            "As Fig. 5.6: EaIP on known and novel (dashed) rectangles after L samples of a person never learned from, "
            f"{example.samples} samples of the posterior and its mean. {of_seed}",
            "observations.png",
        ),
        Picture(
            distance_figure(result),
            f"As Fig. 5.7: DTW distance to demonstrations by L with 95 % bands over seeds ({_origin(result)}).",
            "distance.png",
        ),
    ]


def findings(result: PassingResult, example: PassingExample) -> Findings:
    """Everything that is shown."""
    text = (
        "A person moves a cursor over a rectangle; a robot that has seen others do so completes the motion. All of it "
        "is simulated by a stated generator (simulated/passing.py); the thesis had people at a mouse. Interaction "
        f"primitives learn from {result.study.demonstrations} demonstrations of each of {len(TRAINING)} rectangles: IP "
        "from the cursor alone, EaIP from cursor and the rectangle's width and height, by the same code, each with the "
        "noise that cross-validation on its training demonstrations chose."
    )
    return Findings(
        headline=passing_headline(result),
        sections=[Section(TITLE, text, passing_tables(result), _pictures(result, example))],
        rows=figure_rows(result),
        keys=("arm", "seen", "rectangles", "observed", "floor", "form", "figure", "seed"),
        aims=claims(result),
    )


def run(study: PassingStudy, folder: Path, tell: StageProgress) -> Findings:
    """lfdcore study passing."""
    result = run_passing_study(study, tell)
    return findings(result, PassingExample.of(study))
