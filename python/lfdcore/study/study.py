"""What every study is: a config whose fields are its command's options, a run, and one way to show what was found.

A study reports to people (headline and tables) and to machines (one JSON document with the same keys for all). It also
writes report.html with its version, its seed and the command that repeats it.
"""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import MISSING, Field, dataclass, fields
from pathlib import Path
from typing import Annotated, Any, ClassVar, get_args, get_type_hints

from lfdcore import __version__
from lfdcore.datasets.strict_json import plain_json
from lfdcore.datasets.whole_file import whole_file
from lfdcore.pictures.style import Picture, png
from lfdcore.progress import StageProgress
from lfdcore.study.report.aims import Aim
from lfdcore.study.report.page import Section, report_page
from lfdcore.study.report.table import Table


def under(tell: StageProgress, title: str) -> StageProgress:
    """As `tell`, each stage named after `title`."""
    return lambda stage, done, total: tell(f"{title}: {stage}", done, total)


Row = Mapping[str, object]
FIGURES, REPORT = "figures.json", "report.html"


@dataclass(frozen=True)
class Option:
    """Makes a config's field an option of the study's command; `Annotated[int, Option("...")]`."""

    help: str
    minimum: int | None = None
    maximum: int | None = None
    flag: str = ""
    """as typed, where it is not the field's name: '--map', '--full/--sparse'; 'argument': by position, not by name"""
    repeated: bool = True
    """whether the command that repeats a study names it"""


Seed = Annotated[int, Option("The same seed gives the same bytes.", minimum=0, maximum=2**32 - 1)]
Processes = Annotated[int | None, Option("Default: one a core.", minimum=1, repeated=False)]


@dataclass(frozen=True, kw_only=True)
class Study:
    """Base of all configs. A field without an Option is for Python alone.

    ValueError, as every config, for a number outside its option's bounds.
    """

    name: ClassVar[str]
    """of the command: lfdcore study NAME"""
    title: ClassVar[str]
    """of the report"""

    seed: Seed = 1
    processes: Processes = None

    def __post_init__(self) -> None:
        for name, option in options(type(self)).items():
            _require_inside(name, getattr(self, name), option)

    def command(self) -> str:
        """What repeats the study. The folders of its input and output are left to who repeats it."""
        words, given = ["lfdcore", "study", self.name], options(type(self))
        for name, option in given.items():
            if option.flag == "argument":
                words += _file_names(getattr(self, name))
        words += ["-o", "out"]
        for name, option in given.items():
            if option.repeated and option.flag != "argument":
                words += _words(name, option, getattr(self, name))
        return shlex.join(words)


def options(study: type[Study]) -> dict[str, Option]:
    """Of a config's fields those that are options, in their order, `seed` and `processes` last."""
    hints = get_type_hints(study, include_extras=True)
    said = {one.name: get_args(hints[one.name])[1:] for one in fields(study)}
    found = {name: option for name, about in said.items() for option in about if isinstance(option, Option)}
    last = ("processes", "seed")
    return {name: found[name] for name in [*(n for n in found if n not in last), *last] if name in found}


def default_of(study: type[Study], name: str) -> Any:
    """What a field is where nothing is given; MISSING where it must be."""
    one: Field[Any] = next(one for one in fields(study) if one.name == name)
    return one.default_factory() if one.default_factory is not MISSING else one.default


def _require_inside(name: str, value: object, option: Option) -> None:
    """Also of every element. A number that has bounds counts something: it must be whole."""
    if isinstance(value, tuple):
        for one in value:
            _require_inside(name, one, option)
    if isinstance(value, tuple) or value is None or (option.minimum is None and option.maximum is None):
        return
    if not isinstance(value, int) or isinstance(value, bool):
        raise ValueError(f"{name} is {value!r}, must be a whole number")
    if option.minimum is not None and value < option.minimum:
        raise ValueError(f"{name} is {value}, must be at least {option.minimum}")
    if option.maximum is not None and value > option.maximum:
        raise ValueError(f"{name} is {value}, must be at most {option.maximum}")


def _words(name: str, option: Option, value: Any) -> list[str]:
    flag = option.flag or "--" + name.replace("_", "-")
    if isinstance(value, bool):
        on, _, off = flag.partition("/")
        return [on if value else off] if value or off else []
    if value is None or value == ():
        return []
    several = value if isinstance(value, tuple) and value and isinstance(value[0], Path) else [value]
    return [word for one in several for word in (flag, _written(one))]


def _written(value: Any) -> str:
    if isinstance(value, Path):
        return value.name or str(value)
    return ",".join(map(_written, value)) if isinstance(value, tuple) else str(value)


def _file_names(paths: Any) -> list[str]:
    several = [paths] if isinstance(paths, Path) else paths
    return [Path(one).name or str(one) for one in several]


@dataclass(frozen=True, kw_only=True)
class Findings:
    """What a study found."""

    headline: str
    """the result in a sentence or two"""
    sections: Sequence[Section]
    """of the report: text, tables and pictures"""
    rows: Sequence[Row]
    """all figures for machines, a row what they are about"""
    keys: tuple[str, ...] = ()
    """columns of rows that say what a row is about, `seed` among them where it is about one repetition"""
    aims: Sequence[Aim] = ()
    """figures to reach"""

    @property
    def tables(self) -> list[Table]:
        """Of all sections."""
        return [table for section in self.sections for table in section.tables]

    @property
    def pictures(self) -> list[Picture]:
        """Of all sections."""
        return [picture for section in self.sections for picture in section.pictures]


def as_document(study: Study, findings: Findings) -> dict[str, Any]:
    """For machines: the same keys for every study, in JSON values; what is not finite is None."""
    return {
        "study": study.name,
        "lfdcore": __version__,
        "command": study.command(),
        "seed": study.seed,
        "headline": findings.headline,
        "aims": plain_json([aim.as_row() for aim in findings.aims]),
        "keys": list(findings.keys),
        "rows": plain_json(findings.rows),
    }


def write_study(study: Study, findings: Findings, folder: Path) -> Path:
    """Writes report.html, figures.json and named pictures into `folder` -> the report's path. The same findings give
    the same bytes.

    All is there before the first file is replaced: figures never stand beside an older run's report."""
    document = as_document(study, findings)
    origin = f"lfdcore {__version__}, seed {study.seed}. Made by: `{document['command']}`"
    page = report_page(f"lfdcore: {study.title}", findings.sections, findings.headline, origin)
    files = {
        **{picture.name: png(picture.figure) for picture in findings.pictures if picture.name},
        FIGURES: (json.dumps(document, indent=1, allow_nan=False) + "\n").encode(),
        REPORT: page.encode(),
    }
    folder.mkdir(parents=True, exist_ok=True)
    with ExitStack() as written:
        for name, data in files.items():
            written.enter_context(whole_file(folder / name, "report")).write_bytes(data)
    return folder / REPORT
