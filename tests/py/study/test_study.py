"""The contract that all studies share: options stand once, and what was found is shown in one way."""

import json
from dataclasses import MISSING, dataclass, replace
from pathlib import Path
from typing import Annotated

import numpy as np
import pytest
from matplotlib.figure import Figure

import lfdcore
from lfdcore.pictures.style import Picture
from lfdcore.study.catalogue import STUDIES, load_study
from lfdcore.study.compare import compare, comparison_table, read_document
from lfdcore.study.report.aims import Aim
from lfdcore.study.report.page import Section
from lfdcore.study.report.table import Table
from lfdcore.study.study import Findings, Option, Study, as_document, default_of, options, write_study

NAN = float("nan")


@dataclass(frozen=True, kw_only=True)
class Example(Study):
    """For tests."""

    name = "example"
    title = "an example"
    data: Annotated[tuple[Path, ...], Option("Files.", flag="argument")] = (Path("/some/where/a.npz"),)
    people: Annotated[int, Option("How many.", minimum=1, maximum=9)] = 3
    full: Annotated[bool, Option("All of it.", flag="--full/--sparse")] = True
    courses: Annotated[tuple[str, ...], Option("Names.")] = ("flat", "campus")
    models: Annotated[tuple[Path, ...], Option("Files.", flag="--model")] = ()
    inner: float = 0.5


def found(rows: list[dict[str, object]]) -> Findings:
    return Findings(
        headline="It worked.",
        sections=[Section("S", "", [Table("T", ("", "a"), (("x", "1"),))])],
        rows=rows,
        keys=("arm", "seed"),
        aims=[Aim.at_least(0.5, "share", 0.75, 2)],
    )


def test_a_command_names_every_option_and_leaves_folders_to_who_repeats_it() -> None:
    assert Example().command() == (
        "lfdcore study example a.npz -o out --people 3 --full --courses flat,campus --seed 1"
    )
    other = Example(full=False, models=(Path("m"), Path("n")), people=1, seed=4, processes=2)
    assert other.command().endswith("--people 1 --sparse --courses flat,campus --model m --model n --seed 4")


def test_fields_without_an_option_are_for_python_alone() -> None:
    assert list(options(Example)) == ["data", "people", "full", "courses", "models", "processes", "seed"]


@pytest.mark.parametrize(
    ("name", "value", "bound"), [("people", 0, "at least 1"), ("people", 10, "at most 9"), ("seed", -1, "at least 0")]
)
def test_a_config_refuses_what_its_option_does(name: str, value: int, bound: str) -> None:
    with pytest.raises(ValueError, match=f"{name} is {value}, must be {bound}"):
        replace(Example(), **{name: value})


@pytest.mark.parametrize("name", STUDIES)
def test_every_study_has_the_same_base_and_a_default_for_each_option(name: str) -> None:
    config, run = load_study(name)
    assert issubclass(config, Study)
    assert config.name == name
    assert config.__doc__ and config.__doc__.split("\n")[0].endswith(".")
    for option, about in options(config).items():
        assert (default_of(config, option) is MISSING) == (about.flag == "argument"), option
    assert callable(run)


def test_machines_get_the_same_keys_and_null_where_there_is_no_number(tmp_path: Path) -> None:
    findings = found([{"arm": "a", "seed": 1, "time": NAN, "done": True}])
    write_study(Example(), findings, tmp_path)

    def refuse(constant: str) -> None:
        pytest.fail(f"{constant} is no JSON")

    document = json.loads((tmp_path / "figures.json").read_text(), parse_constant=refuse)
    assert document == as_document(Example(), findings)
    assert list(document) == ["study", "lfdcore", "command", "seed", "headline", "aims", "keys", "rows"]
    assert document["rows"] == [{"arm": "a", "seed": 1, "time": None, "done": True}]
    assert document["aims"][0] | {"low": None} == document["aims"][0]


def test_a_report_says_version_seed_headline_and_what_repeats_it(tmp_path: Path) -> None:
    page = write_study(Example(), found([]), tmp_path).read_text()
    for text in (f"lfdcore {lfdcore.__version__}, seed 1", "It worked.", Example().command(), "lfdcore: an example"):
        assert text in page


def test_aims_are_reached_at_their_bound_and_say_it_once() -> None:
    assert Aim.at_least(0.87, "x", 0.87, 2).reached
    assert not Aim.at_most(0.04, "x", 0.0401, 3).reached
    assert not Aim.at_least(0.87, "x", NAN, 2).reached
    wanted = [
        Aim.at_least(0.87, "", 0, 2),
        Aim.at_most(0.04, "", 0, 2),
        Aim.between(0.5, 2, "", 1, 2),
        Aim.between(0, 0, "", 0, 0),
    ]
    assert [aim.wanted for aim in wanted] == [">= 0.87", "<= 0.04", "0.5 - 2", "0"]
    shown = Aim.at_most(1, "x", 0.5, 2, low=0.4, high=0.6, note="n 7").as_text()
    assert shown == "0.50\nreached\n[0.40, 0.60]\nn 7"


def test_numpy_values_and_what_is_not_finite_become_json_at_any_depth() -> None:
    rows: list[dict[str, object]] = [{"n": np.int64(3), "each": np.array([1.0, NAN]), "deep": ({"x": [NAN]},)}]
    said = as_document(Example(), found(rows))["rows"]
    assert json.loads(json.dumps(said, allow_nan=False)) == [{"n": 3, "each": [1.0, None], "deep": [{"x": [None]}]}]


@pytest.mark.parametrize("people", [3.5, True, "3", 0, 10])
def test_a_count_that_is_none_is_refused(people: object) -> None:
    with pytest.raises(ValueError, match="people is"):
        Example(people=people)  # type: ignore[arg-type]


def test_a_report_that_cannot_be_written_leaves_the_old_one_whole(tmp_path: Path) -> None:
    write_study(Example(), found([]), tmp_path)
    before = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    unwritable = Picture(Figure(), "", "x/y.png")  # there is no folder x
    broken = replace(found([]), headline="Another.", sections=[Section("", "", pictures=[unwritable])])
    with pytest.raises(OSError, match=r"y\.png"):
        write_study(Example(), broken, tmp_path)
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == before


# -- compare --------------------------------------------------------------------------------------------------------


def document(times: dict[int, float], **changes: object) -> dict[str, object]:
    rows: list[dict[str, object]] = [{"arm": "a", "seed": seed, "time": time} for seed, time in times.items()]
    return as_document(Example(), found(rows)) | changes


def test_runs_are_paired_where_their_seeds_agree() -> None:
    first, second = document({1: 1.0, 2: 2.0, 3: 3.0}), document({3: 3.5, 2: 2.5, 4: 99.0})
    (one,) = compare(first, second)
    assert (one.about, one.figure, one.paired) == ({"arm": "a"}, "time", True)
    assert (list(one.first), list(one.second)) == ([2.0, 3.0], [2.5, 3.5])
    assert one.difference[0] == pytest.approx(0.5)


def test_runs_without_a_common_seed_are_not_paired() -> None:
    (one,) = compare(document({1: 1.0, 2: 3.0}), document({7: 5.0}))
    assert not one.paired
    assert one.difference[0] == pytest.approx(3.0)
    assert one.p != one.p


def test_of_a_study_with_repetitions_only_those_are_compared_and_bounds_never() -> None:
    one, other = (document({1: 1.0, 2: t}) for t in (2.0, 3.0))
    for both in (one, other):
        both["rows"].append({"arm": "a", "time": 1.5, "low": 0.1, "n": 2, "reached": True})
        both["rows"][0]["time_low"] = 0.5
    (found,) = compare(one, other)
    assert (found.figure, list(found.first)) == ("time", [1.0, 2.0])


def test_without_seeds_nothing_is_paired() -> None:
    one, other = (document({1: t}, keys=["arm"]) for t in (2.0, 3.0))
    for both in (one, other):
        del both["rows"][0]["seed"]
    (found,) = compare(one, other)
    assert (found.paired, found.difference[0]) == (False, 1.0)


def test_what_has_no_seed_is_never_paired_by_its_place() -> None:
    rows = [{"arm": "a", "seed": 1, "time": 1.0}, {"arm": "b", "error": 1.0}, {"arm": "c", "error": 2.0}]
    first, second = (as_document(Example(), found(which)) for which in (rows, [rows[0], rows[2], rows[1]]))
    assert all(list(one.first) == list(one.second) for one in compare(first, second))
    assert [one.paired for one in compare(first, second)] == [True, False, False]


def test_rows_that_the_keys_do_not_tell_apart_are_refused() -> None:
    twice = document({1: 1.0})
    twice["rows"] *= 2  # type: ignore[operator]
    with pytest.raises(ValueError, match="two rows of study example are about"):
        compare(twice, twice)


def test_a_small_change_is_not_written_as_none() -> None:
    table = comparison_table(document({1: 0.12341, 2: 0.2}), document({1: 0.12342, 2: 0.2}))
    assert table.rows[0][3].startswith("0.00000500\n[")


def test_the_table_shows_what_differs_and_counts_what_does_not() -> None:
    first, second = document({1: 1.0, 2: 2.0}), document({1: 1.0, 2: 2.5})
    table = comparison_table(first, second)
    assert [(row[0], row[4]) for row in table.rows] == [("a\ntime", "2")]
    assert "1 of 1 figures are equal" in comparison_table(first, first).note


def test_what_cannot_be_compared_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="of study example and of study other"):
        compare(document({1: 1.0}), document({1: 1.0}, study="other"))
    with pytest.raises(ValueError, match="no figure in common"):
        compare(document({1: 1.0}), document({}))
    (tmp_path / "figures.json").write_text("[1, 2]")
    with pytest.raises(lfdcore.errors.DataError, match="holds no figures of a study"):
        read_document(tmp_path)
    for rows in ("[1]", '[{"arm": [1]}]'):
        (tmp_path / "figures.json").write_text(
            '{"study": "x", "command": "", "lfdcore": "", "keys": ["arm"], "rows": ' + rows + "}"
        )
        with pytest.raises(lfdcore.errors.DataError, match="row 0 is no row of figures"):
            read_document(tmp_path)
    (tmp_path / "figures.json").write_text("{")
    with pytest.raises(lfdcore.errors.DataError, match="holds no JSON"):
        read_document(tmp_path / "report.html")
