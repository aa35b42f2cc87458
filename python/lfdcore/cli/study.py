"""lfdcore study: experiments with tables, pictures and a report. A config's fields are its command's options."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import MISSING
from inspect import Parameter, Signature
from pathlib import Path
from tempfile import TemporaryFile
from typing import TYPE_CHECKING, Annotated, Any, get_args, get_type_hints

import typer
from typer.core import TyperGroup
from typer.main import get_command

from lfdcore.cli.common import JsonOption, Stages, print_json, progress_bar

if TYPE_CHECKING:
    from lfdcore.study.catalogue import Run
    from lfdcore.study.study import Option, Study

OutputOption = Annotated[Path, typer.Option("--output", "-o", help="Folder for the report, its pictures and figures.")]


class StudyGroup(TyperGroup):
    """Makes a study's command when it is asked for, from its config."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Studies, then what is done with their reports."""
        from lfdcore.study.catalogue import STUDIES

        return [*STUDIES, *super().list_commands(ctx)]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """None for an unknown name."""
        from lfdcore.study.catalogue import STUDIES, load_study

        if cmd_name not in STUDIES:
            return super().get_command(ctx, cmd_name)
        alone = typer.Typer(add_completion=False)
        alone.command(cmd_name)(study_command(*load_study(cmd_name)))
        return get_command(alone)


app = typer.Typer(cls=StudyGroup, help="Run a study: tables, pictures, one report.html.", no_args_is_help=True)


@app.command("compare")
def compare(
    first: Annotated[Path, typer.Argument(help="A report.html, its folder or its figures.json.")],
    second: Annotated[Path, typer.Argument(help="Another run of the same study.")],
    as_json: JsonOption = False,
) -> None:
    """The figures of two runs of a study side by side, paired where their seeds agree."""
    from dataclasses import asdict

    from lfdcore.study.compare import compare, comparison_table, read_document

    documents = read_document(first), read_document(second)
    if as_json:
        print_json([asdict(one) | {"difference": one.difference, "p": one.p} for one in compare(*documents)])
        return
    typer.echo(comparison_table(*documents).as_text())


def study_command(config: type[Study], run: Run) -> Callable[..., None]:
    """What runs a study from the command line: its options are the config's, then --output and --json."""

    def command(**given: Any) -> None:
        folder, as_json, hints = given.pop("output"), given.pop("as_json"), get_type_hints(config)
        study = config(**{name: _field(name, hints[name], value) for name, value in given.items()})
        run_study(study, run, folder, as_json)

    command.__doc__ = config.__doc__
    signature = _signature(config)
    command.__signature__ = signature  # type: ignore[attr-defined]
    command.__annotations__ = {name: one.annotation for name, one in signature.parameters.items()}
    return command


def run_study(study: Study, run: Run, folder: Path, as_json: bool) -> None:
    """Runs a study with progress, writes its report into `folder` and shows what was found."""
    from lfdcore.study.report.table import WIDTH, wrapped
    from lfdcore.study.study import as_document, write_study

    with _made(folder), progress_bar() as bar:
        findings = run(study, folder, Stages(bar))
        report = write_study(study, findings, folder)
    if as_json:
        print_json({"report": str(report)} | as_document(study, findings))
        return
    typer.echo("\n".join(wrapped(findings.headline, WIDTH)) + "\n")
    for table in findings.tables:
        typer.echo(table.as_text())
    typer.echo(f"report: {report}")


@contextmanager
def _made(folder: Path) -> Iterator[None]:
    """The folder is there meanwhile; one that was made for a study that was refused goes again."""
    new = [one for one in (folder, *folder.parents) if not one.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    try:
        with TemporaryFile(dir=folder):  # OSError now, not after the work
            pass
        yield
    except BaseException:
        for one in new:
            if not any(one.iterdir()):
                one.rmdir()
        raise


def _signature(config: type[Study]) -> Signature:
    from lfdcore.study.study import default_of, options

    hints = get_type_hints(config)
    parameters = [_parameter(name, hints[name], default_of(config, name), one) for name, one in options(config).items()]
    parameters.append(Parameter("output", Parameter.KEYWORD_ONLY, annotation=OutputOption))
    parameters.append(Parameter("as_json", Parameter.KEYWORD_ONLY, default=False, annotation=JsonOption))
    return Signature(parameters)


def _parameter(name: str, hint: Any, default: Any, option: Option) -> Parameter:
    bounds: dict[str, Any] = {"min": option.minimum, "max": option.maximum} if int in (hint, *get_args(hint)) else {}
    if option.flag == "argument":
        about: Any = typer.Argument(help=option.help)
    else:
        flags = [option.flag] if option.flag else []
        about = typer.Option(*flags, help=option.help, **bounds)
    hint, default = _typed(hint, default)
    given = Parameter.empty if default is MISSING else default
    return Parameter(name, Parameter.KEYWORD_ONLY, default=given, annotation=Annotated[hint, about])


def _typed(hint: Any, default: Any) -> tuple[Any, Any]:
    """A field's type as it is typed on a command line: several files one by one, other tuples parted by commas."""
    if hint == tuple[Path, ...]:
        return list[Path], default if default is MISSING else list(default)
    if hint in (tuple[str, ...], tuple[int, ...]):
        return str, default if default is MISSING else ",".join(map(str, default))
    return hint, default


def _field(name: str, hint: Any, typed: Any) -> Any:
    """The reverse of _typed: what the config holds."""
    if hint == tuple[Path, ...]:
        return tuple(typed)
    if hint == tuple[str, ...]:
        return tuple(word.strip() for word in typed.split(","))
    if hint == tuple[int, ...]:
        try:
            return tuple(int(word) for word in typed.split(","))
        except ValueError as error:
            raise ValueError(f"{name} are '{typed}', must be whole numbers parted by commas") from error
    return typed
