"""lfdcore predict: what models predict along recorded drives, a posteriori (Fig. 3.16; Table 4.2 with Fig. 4.16)."""

from __future__ import annotations

import dataclasses
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lfdcore.cli.common import (
    JsonOption,
    PresetOption,
    SeedOption,
    Stages,
    footprint_of,
    print_json,
    progress_bar,
    require_drawable,
    require_each_once,
    save_picture,
)
from lfdcore.cli.log_options import (
    AxesOption,
    CommandOption,
    JoyOption,
    LogOptions,
    MountingOption,
    OdometryOption,
    ScanOption,
)
from lfdcore.progress import Progress
from lfdcore.study.preset import Preset

if TYPE_CHECKING:
    from lfdcore.datasets.drive_log import DriveLog
    from lfdcore.geometry import Footprint
    from lfdcore.study.heatmaps.comparison import ComparedModels, Comparison
    from lfdcore.study.prediction.study import LogPrediction
    from lfdcore.wheelchair.method import MethodModel, Predictor
    from lfdcore.wheelchair.stick import StickMeaning


class Rule(StrEnum):
    """How a path comes out of the intention map."""

    median = "median"
    goal = "goal"


class Stick(StrEnum):
    """By which limits a log without a joystick gets one."""

    demonstrated = "demonstrated"
    own = "own"


def predict(
    files: Annotated[
        list[Path], typer.Argument(metavar="MODEL... LOG...", help="Learned models and drive logs, in any order.")
    ],
    begin: Annotated[float, typer.Option("--from", min=0, max=1, help="Share of each log's scans to begin at.")] = 0.0,
    end: Annotated[float, typer.Option("--to", min=0, max=1, help="Share of each log's scans to end at.")] = 1.0,
    rule: Annotated[
        Rule | None,
        typer.Option(help="Of path primitives. Default: median of all cells' votes; goal: path to the likeliest cell."),
    ] = None,
    stick: Annotated[
        Stick, typer.Option(help="What an inferred joystick means: a stick as demonstrated, or the log's own limits.")
    ] = Stick.demonstrated,
    picture: Annotated[
        Path | None, typer.Option(help="Where a picture like Fig. 3.16 goes (.png, .pdf, .svg).")
    ] = None,
    concatenated: Annotated[
        Path | None,
        typer.Option(
            help="Compare one model of each kind as in Table 4.2 too, planning every .5 s; where the picture like "
            "Fig. 4.16 goes (.png, .pdf, .svg)."
        ),
    ] = None,
    footprint: Annotated[
        str, typer.Option(help="FRONT,REAR,HALF_WIDTH of the robot in the picture, in metres.")
    ] = ".8,.35,.35",
    scan: ScanOption = None,
    odometry: OdometryOption = None,
    joy: JoyOption = None,
    axes: AxesOption = None,
    command: CommandOption = None,
    mounting: MountingOption = None,
    preset: PresetOption = Preset.default,
    seed: SeedOption = 1,
    as_json: JsonOption = False,
) -> None:
    """Predict paths along recorded drives and compare them with what was driven: path error beside two baselines."""
    from lfdcore.study.prediction.study import predict_log
    from lfdcore.wheelchair.stick import StickMeaning

    if not begin < end:
        raise typer.BadParameter(f"--from {begin} must be less than --to {end}")
    require_drawable("--picture", picture)
    require_drawable("--concatenated", concatenated)
    outline = footprint_of(footprint)
    model_files, log_files = _models_and_logs(files)
    models = _load(model_files)
    predictors = _predictors(model_files, models, rule, preset)
    compared = None if concatenated is None else _of_each_kind(model_files, models)
    options = LogOptions(scan, odometry, joy, axes, command, mounting)
    logs = [options.open(path).share(begin, end) for path in log_files]
    meaning = StickMeaning(stick)
    with progress_bar() as bar:
        tell = Stages(bar)
        predictions = [predict_log(log, predictors, meaning, tell.step(log.name)) for log in logs]
        comparison = None if compared is None else _compare(logs, compared, meaning, tell.step("compare"))
    if comparison is not None and concatenated is not None:
        _draw_concatenated(comparison, concatenated)
    if picture is not None:
        _draw(predictions, outline, picture)
    if as_json:
        _print_json(predictions, comparison, begin, end, seed)
    else:
        _print(predictions, comparison, begin, end, seed)
    if all(prediction.outcome for prediction in predictions):
        raise typer.Exit(1)


def _print_json(
    predictions: list[LogPrediction], comparison: Comparison | None, begin: float, end: float, seed: int
) -> None:
    from lfdcore.study.prediction.tables import as_json, pooled_rows

    together = [dataclasses.asdict(row) for row in pooled_rows(predictions, seed)]
    logs = [as_json(prediction, seed) for prediction in predictions]
    found = {"from": begin, "to": end, "seed": seed, "logs": logs, "together": together}
    print_json(found | ({} if comparison is None else {"comparison": _figures(comparison)}))


def _print(
    predictions: list[LogPrediction], comparison: Comparison | None, begin: float, end: float, seed: int
) -> None:
    """A table a log, one of all logs where several have samples, and Table 4.2 where it was asked for."""
    from lfdcore.study.prediction.tables import as_text, pooled_text

    typer.echo(f"Scans {begin:g} to {end:g} of each log; intervals: block bootstrap over 5 m of way, seed {seed}.\n")
    for prediction in predictions:
        typer.echo(as_text(prediction, seed))
    if sum(not prediction.outcome for prediction in predictions) > 1:
        typer.echo(pooled_text(predictions, seed))
    if comparison is not None:
        from lfdcore.study.heatmaps.report import comparison_table

        typer.echo(comparison_table(comparison, None).as_text())


def _draw_concatenated(comparison: Comparison, picture: Path) -> None:
    from lfdcore.study.heatmaps.pictures import concatenated_figure, median_runs

    save_picture(concatenated_figure(median_runs(comparison.runs)), picture)


def _predictors(
    files: list[Path], models: dict[str, MethodModel], rule: Rule | None, preset: Preset
) -> dict[str, Predictor]:
    """Each model's own; with --rule or --preset thesis, which say how path primitives predict, of these alone."""
    if rule is None and preset is Preset.default:
        return {name: model.predictor() for name, model in models.items()}
    from dataclasses import replace

    from lfdcore.wheelchair.primitives.model import DriveAssistantModel
    from lfdcore.wheelchair.primitives.prediction import PathPredictionConfig, PathPredictor

    others = [name for name, model in models.items() if model.method != DriveAssistantModel.method]
    if others:
        option = f"--rule {rule.value}" if rule is not None else "--preset thesis"
        raise typer.BadParameter(f"{option} is of path primitives, and {', '.join(others)} holds none")
    config = PathPredictionConfig.thesis() if preset is Preset.thesis else PathPredictionConfig()
    config = config if rule is None else replace(config, rule=rule.value)
    loaded = map(DriveAssistantModel.load, files)
    return {name: PathPredictor(model, config) for name, model in zip(models, loaded, strict=True)}


def _of_each_kind(files: list[Path], models: dict[str, MethodModel]) -> ComparedModels:
    from lfdcore.study.heatmaps.comparison import ModelFiles

    methods = [model.method for model in models.values()]
    if sorted(methods) != ["heatmaps", "naive", "primitives"]:
        counts = tuple(methods.count(method) for method in ("primitives", "naive", "heatmaps"))
        given = "{} of primitives, {} naive, {} of heatmaps".format(*counts)
        raise typer.BadParameter(f"--concatenated compares one model of each kind; given are {given}")
    return ModelFiles(**dict(zip(methods, files, strict=True))).load()


def _compare(logs: list[DriveLog], models: ComparedModels, meaning: StickMeaning, tell: Progress) -> Comparison:
    """A stick that was not recorded is one for all methods: what the heatmaps' demonstrations meant by it."""
    from lfdcore.study.heatmaps.comparison import Comparison, ComparisonConfig, compare_on_log
    from lfdcore.wheelchair.stick import with_stick

    runs, config = [], ComparisonConfig()
    tell(0, len(logs))
    for log in logs:
        runs.append(compare_on_log(with_stick(log, models.heatmaps, meaning), models, config))
        tell(len(runs), len(logs))
    return Comparison(tuple(runs), config)


def _figures(comparison: Comparison) -> dict[str, dict[str, list[float]]]:
    """A value a log, of every method"""
    figures = ("reward", "rank", "near", "whole", "at_equal_length", "without_path", "seconds")
    methods = comparison.runs[0].methods
    return {method: {name: comparison.column(method, name).tolist() for name in figures} for method in methods}


def _models_and_logs(files: list[Path]) -> tuple[list[Path], list[Path]]:
    for file in files:
        if not file.exists():
            raise FileNotFoundError(2, "no such model or drive log", str(file))
    require_each_once(files)
    models = [file for file in files if _is_model(file)]
    logs = [file for file in files if file not in models]
    if not models or not logs:
        raise typer.BadParameter(f"{len(models)} models and {len(logs)} logs given, at least one of each is needed")
    return models, logs


def _is_model(file: Path) -> bool:
    from lfdcore.datasets.tensor_file import is_tensor_file

    return file.is_file() and (file.suffix == ".safetensors" or is_tensor_file(file))


def _load(files: list[Path]) -> dict[str, MethodModel]:
    """By stem; by whole path where two have the same."""
    from lfdcore.wheelchair.models import load_model

    stems = [file.stem for file in files]
    names = [file.stem if stems.count(file.stem) == 1 else str(file) for file in files]
    return {name: load_model(file) for name, file in zip(names, files, strict=True)}


def _draw(predictions: list[LogPrediction], outline: Footprint, picture: Path) -> None:
    from lfdcore.study.prediction.picture import prediction_figure

    if all(prediction.outcome for prediction in predictions):
        typer.echo(f"{picture} is not drawn: no log has a sample", err=True)
        return
    save_picture(prediction_figure(predictions, outline), picture)
