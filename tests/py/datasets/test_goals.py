"""goals.yaml: what is written is read; what cannot be destinations is refused with file, goal and reason."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lfdcore.datasets import Goal, Goals, read_goals, write_goals, write_map
from lfdcore.errors import DataError
from lfdcore.grid import OccupancyGrid

TWO = "goals:\n- {name: kitchen, x: 1.0, y: 2}\n- {name: hall, x: 3.5, y: 1.25}\n"

names = st.text(st.characters(codec="utf-8", exclude_categories=["C", "Z"]), min_size=1, max_size=12)
metres = st.floats(-1e6, 1e6)
goals = st.lists(st.tuples(names, metres, metres), min_size=2, max_size=9, unique_by=(lambda g: g[0], lambda g: g[1]))


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "goals.yaml"


@given(goals)
def test_what_is_written_is_read_to_the_last_bit(tmp_path_factory: pytest.TempPathFactory, drawn: list[tuple]) -> None:
    path = tmp_path_factory.mktemp("goals") / "goals.yaml"
    written = Goals(tuple(Goal(*one) for one in drawn))
    write_goals(written, path)
    assert read_goals(path) == written


def test_goals_come_in_the_files_order(file: Path) -> None:
    file.write_text(TWO)
    read = read_goals(file)
    assert read.names == ("kitchen", "hall")
    np.testing.assert_array_equal(read.positions, [[1, 2], [3.5, 1.25]])
    assert (read.map, len(read), read.index("hall")) == (None, 2, 1)


def test_a_map_beside_the_file_travels_with_it(file: Path, tmp_path: Path) -> None:
    write_map(OccupancyGrid(np.zeros((40, 80), np.int8), 0.1, (0.0, 0.0)), tmp_path / "flat.yaml")
    write_goals(Goals((Goal("a", 1, 2), Goal("b", 7.9, 3.9)), tmp_path / "flat.yaml"), file)
    assert "map: flat.yaml" in file.read_text()
    assert read_goals(file).map == tmp_path / "flat.yaml"


@pytest.mark.parametrize("x, y", [(8.0, 1.0), (-0.01, 1.0), (1.0, 4.0), (1.0, -3.0)])
def test_a_goal_outside_the_map_is_named_with_the_maps_bounds(file: Path, tmp_path: Path, x: float, y: float) -> None:
    write_map(OccupancyGrid(np.zeros((40, 80), np.int8), 0.1, (0.0, 0.0)), tmp_path / "flat.yaml")
    file.write_text(f"map: flat.yaml\ngoals:\n- {{name: a, x: 1, y: 2}}\n- {{name: away, x: {x}, y: {y}}}\n")
    with pytest.raises(DataError, match=r"goals\.yaml: goal 'away' is at .* outside the map: x 0 to 8 m, y 0 to 4 m"):
        read_goals(file)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "must hold map, goals"),
        ("- 1", "must hold map, goals"),
        ("map: 3", "goals is None, must be a list"),
        ("goals: {a: [1, 2]}", "must be a list of name, x, y"),
        ("goals: []", "there are 0 goals, must be at least 2"),
        ("goals:\n- {name: a, x: 1, y: 2}", "there are 1 goals, must be at least 2"),
        (TWO + "speed: 3", "unknown key 'speed'"),
        (TWO + "- {name: c, x: 1, y: 9, z: 1}", "goal 3 has the unknown key 'z'"),
        (TWO + "- {name: c, x: 1}", "goal 3 has no y"),
        (TWO + "- {name: 7, x: 1, y: 9}", "name of goal 3 is 7, must be a text"),
        (TWO + "- {name: ' ', x: 1, y: 9}", "must be a text that is not empty"),
        (TWO + '- {name: "a\\nb", x: 1, y: 9}', "must be a text that is not empty, in one line"),
        (TWO + '- {name: "\\e[31mred", x: 1, y: 9}', "must be a text that is not empty, in one line"),
        (TWO + "- {name: c, x: .nan, y: 9}", "x of goal 'c' is nan m, must be finite"),
        (TWO + "- {name: c, x: .inf, y: 9}", "x of goal 3 is inf|x of goal 'c' is inf"),
        (TWO + "- {name: c, x: 1, y: 2.0e+7}", "y of goal 'c' is 20000000.0 m, must be finite and within 1e\\+06"),
        (TWO + "- {name: c, x: one, y: 9}", "x of goal 3 is 'one', must be a number"),
        (TWO + "- {name: c, x: true, y: 9}", "x of goal 3 is True, must be a number"),
        (TWO + "- {name: c, x: 1" + "0" * 400 + ", y: 9}", "x of goal 3 is .*, must be a number"),
        (TWO + "- {name: hall, x: 1, y: 9}", "2 goals are named 'hall'"),
        (TWO + "- {name: c, x: 1, y: 2}", r"2 goals are at \(1.0, 2.0\)"),
        (TWO + "- {name: c, x: 1, x: 2, y: 9}", "key x comes 2 times"),
        (TWO + TWO, "key goals comes 2 times"),
        (TWO + "map: [1]", "map is \\[1\\], must be the path"),
        ("goals: [1, 2", "is no YAML of goals"),
        ("goals: [!!python/object:os.system {}]", "is no YAML of goals"),
        ("goals: !!bool foo", "is no YAML of goals"),
        ('goals: !!int ""', "is no YAML of goals"),
        ("{[1]: 2}", "is no YAML of goals"),
        ("\x00\x01", "is no YAML of goals"),
    ],
)
def test_a_broken_file_is_a_data_error_that_says_where(file: Path, text: str, reason: str) -> None:
    file.write_text(text)
    with pytest.raises(DataError, match=reason) as caught:
        read_goals(file)
    assert str(file) in str(caught.value)


def test_a_file_too_long_for_destinations_is_refused_unread(file: Path) -> None:
    file.write_text(TWO + "# " + "x" * 200_000)
    with pytest.raises(DataError, match=r"has 2000\d\d bytes, goals have at most 200000"):
        read_goals(file)


def test_thousands_of_keys_that_all_differ_are_read_once(file: Path) -> None:
    """Not a time for each pair of them: that would be minutes."""
    file.write_text("{" + ", ".join(f"k{i}: 1" for i in range(15_000)) + "}")
    with pytest.raises(DataError, match="unknown key 'k0'"):
        read_goals(file)


def test_a_folder_is_no_file_of_goals_and_no_file_is_not_found(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="no regular file"):
        read_goals(tmp_path)
    with pytest.raises(FileNotFoundError):
        read_goals(tmp_path / "none.yaml")


def test_goals_made_in_python_are_checked_likewise() -> None:
    with pytest.raises(ValueError, match="at least 2"):
        Goals((Goal("a", 0, 0),))
    with pytest.raises(ValueError, match="2 goals are named 'a'"):
        Goals((Goal("a", 0, 0), Goal("a", 1, 0)))
    with pytest.raises(ValueError, match="goal is 'c', must be one of a, b"):
        Goals((Goal("a", 0, 0), Goal("b", 1, 0))).index("c")
    with pytest.raises(ValueError, match="must end in"):
        write_goals(Goals((Goal("a", 0, 0), Goal("b", 1, 0))), "goals.txt")
