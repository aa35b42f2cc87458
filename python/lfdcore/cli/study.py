"""lfdcore study: experiments with tables, pictures and a report."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lfdcore.cli.common import JsonOption, SeedOption, Stages, print_json, progress_bar
from lfdcore.cli.study_adaptation import study_adaptation
from lfdcore.cli.study_backwards import study_backwards
from lfdcore.cli.study_covering import study_covering
from lfdcore.cli.study_goals import study_goals
from lfdcore.cli.study_handovers import study_handovers
from lfdcore.cli.study_joints import study_joints
from lfdcore.cli.study_learning_curve import study_learning_curve
from lfdcore.cli.study_passing import study_passing
from lfdcore.cli.study_sequences import study_sequences

if TYPE_CHECKING:
    from lfdcore.study.arms import StudyModels
    from lfdcore.study.driving.study import DrivingResult
    from lfdcore.study.driving.tasks import TaskResult
    from lfdcore.study.report.page import Section

More = Callable[["StudyModels", Stages], "Sequence[Section]"]

app = typer.Typer(help="Run a study: tables, pictures, one report.html.", no_args_is_help=True)


@app.callback()
def _group() -> None:
    """Run a study: tables, pictures, one report.html."""


@dataclass(frozen=True)
class DrivingPlan:
    """What a driving study is to do."""

    output: Path
    models: tuple[Path, ...]
    courses: str
    arms: str
    drivers: int
    starts: int
    seed: int
    processes: int | None = None

    def command(self) -> str:
        """What repeats the study; the folder is left to who does."""
        words = ["lfdcore", "study", "driving", "-o", "out", "--courses", self.courses, "--assistants", self.arms]
        words += ["--drivers", str(self.drivers), "--task-starts", str(self.starts), "--seed", str(self.seed)]
        return shlex.join(words + [word for model in self.models for word in ("--model", str(model))])


@dataclass(frozen=True)
class DrivingOutcome:
    """What it came to."""

    result: DrivingResult
    tasks: TaskResult | None
    report: Path

    def print_tables(self) -> None:
        """The result in a line, all tables, then the report's path."""
        from lfdcore.study.driving.tables import driving_tables, headline, task_tables
        from lfdcore.study.report.table import WIDTH, wrapped

        typer.echo("\n".join(wrapped(headline(self.result), WIDTH)) + "\n")
        for table in driving_tables(self.result) + (task_tables(self.tasks) if self.tasks else []):
            typer.echo(table.as_text())
        typer.echo(f"report: {self.report}")


def drive_and_report(plan: DrivingPlan, more: More = lambda models, tell: (), command: str = "") -> DrivingOutcome:
    """Learns what the arms need and was not given, drives courses and tasks, writes the report.

    `more` makes sections of the models, telling how far it is; `command` is named in the report as what
    made it, else the plan's own.
    """
    from lfdcore.simulated.courses import course_by_name
    from lfdcore.study.arms import models_by_method, require_arms, require_once
    from lfdcore.study.driving.report import write_driving_report
    from lfdcore.study.driving.study import DrivingStudy, run_driving_study
    from lfdcore.study.driving.tasks import TaskStudy, run_task_study

    given = models_by_method(plan.models)  # refused before anything is driven
    courses = tuple(course_by_name(name, plan.seed) for name in plan.courses.split(","))
    arms = tuple(plan.arms.split(","))
    require_arms(arms)
    require_once("course", [course.name for course in courses])
    plan.output.mkdir(parents=True, exist_ok=True)
    with progress_bar() as bar:
        tell = Stages(bar)
        models = _learn_what_is_missing(plan, arms, given, tell)
        study = DrivingStudy(courses=courses, models=models, arms=arms, drivers=plan.drivers, seed=plan.seed)
        result = run_driving_study(study, tell.step("drive courses never seen"), plan.processes)
        tasks = None
        if plan.starts:
            task_study = TaskStudy(models=models, arms=arms, starts=plan.starts, seed=plan.seed)
            tasks = run_task_study(task_study, tell.step("tasks: docking, narrow gap"), plan.processes)
        sections = more(models, tell)
        told = tell.step("report")
        told(0, 1)
        demonstrations = [] if given.file("primitives") else sorted(plan.output.glob("demonstration-*.mcap"))
        report = write_driving_report(
            result,
            plan.output,
            sections,
            demonstrations=demonstrations,
            tasks=tasks,
            command=command or plan.command(),
        )
        told(1, 1)
    return DrivingOutcome(result, tasks, report)


def _learn_what_is_missing(plan: DrivingPlan, arms: Sequence[str], given: StudyModels, tell: Stages) -> StudyModels:
    """The models that the arms need, learned from demonstrations where none was given."""
    from lfdcore.study.arms import METHODS, StudyModels
    from lfdcore.study.demonstrations import learn_from_demonstrations, learn_heatmaps_from_demonstrations

    needed = {METHODS[arm] for arm in arms if arm in METHODS}
    primitives, heatmaps = given.file("primitives"), given.file("heatmaps")
    if primitives is None and "primitives" in needed:
        primitives = learn_from_demonstrations(plan.output, plan.seed, progress=tell.step("learn primitives"))
    if heatmaps is None and "heatmaps" in needed:
        told = tell.under("heatmaps")
        heatmaps = learn_heatmaps_from_demonstrations(plan.output, plan.seed, told, processes=plan.processes)
    return StudyModels(primitives=primitives, heatmaps=heatmaps)


@app.command("driving")
def study_driving(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the report, its pictures and figures.")],
    models: Annotated[
        list[Path] | None,
        typer.Option("--model", help="A learned model, once a method; what is missing is learned from demonstrations."),
    ] = None,
    courses: Annotated[
        str, typer.Option(help="Comma-separated names of courses or map .yaml files.")
    ] = "standard_course",
    arms: Annotated[
        str,
        typer.Option(
            "--assistants", help="Of none, dwa, primitives, heatmaps; dwa_1s, supervisor, thesis, heatmaps_thesis."
        ),
    ] = "none,dwa,primitives,heatmaps",
    drivers: Annotated[int, typer.Option(min=1, help="Simulated impaired drivers.")] = 10,
    starts: Annotated[int, typer.Option("--task-starts", min=0, help="Starts of each task; 0: no tasks.")] = 20,
    processes: Annotated[int | None, typer.Option(min=1, help="Default: one a core.")] = None,
    seed: SeedOption = 1,
    as_json: JsonOption = False,
) -> None:
    """Drivers x courses x assistants: Tables 3.1-3.3 and 4.1 with intervals, tasks, pictures of every course."""
    plan = DrivingPlan(output, tuple(models or ()), courses, arms, drivers, starts, seed, processes)
    outcome = drive_and_report(plan)
    if as_json:
        print_json({"report": str(outcome.report), "rows": list(outcome.result.rows)})
        return
    outcome.print_tables()


app.command("learning-curve")(study_learning_curve)
app.command("covering")(study_covering)
app.command("goals")(study_goals)
app.command("adaptation")(study_adaptation)
app.command("backwards")(study_backwards)
app.command("passing")(study_passing)
app.command("handovers")(study_handovers)
app.command("sequences")(study_sequences)
app.command("joints")(study_joints)
