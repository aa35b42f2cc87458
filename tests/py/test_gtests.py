"""How the C++ tests are laid out: each follows one header, and each name states a claim."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TESTS = ROOT / "tests" / "cpp"
ABOUT_SEVERAL_HEADERS = {
    TESTS / "steady_state_test.cpp",
    TESTS / "control" / "supervisor_promise_test.cpp",
    TESTS / "control" / "supervisor_touch_test.cpp",
    TESTS / "hardware" / "joystick_firmware_test.cpp",
}


def headers(module: str, name: str) -> list[str]:
    """The include paths, seen from a test, under which the header that it is named after exists."""
    public, private = Path("lfdcore", module, name), Path("cpp", "src", module, name)
    up = "../" * (2 + bool(module))
    return [
        *([str(public)] if (ROOT / "cpp" / "include" / public).exists() else []),
        *([f"{up}{private}"] if (ROOT / private).exists() else []),
    ]


@pytest.mark.parametrize(
    "path", sorted({*TESTS.rglob("*_test.cpp")} - ABOUT_SEVERAL_HEADERS), ids=lambda p: str(p.relative_to(TESTS))
)
def test_a_gtest_file_is_named_after_the_header_that_it_includes_first(path: Path) -> None:
    module = "" if path.parent == TESTS else path.parent.name
    subject = headers(module, f"{path.stem.removesuffix('_test')}.hpp")
    assert subject, f"{path.relative_to(ROOT)} follows no header of {module or 'the vocabulary'}"
    first = re.search(r'#include "([^"]*)"', path.read_text())
    assert first and first[1] in subject


def test_the_exceptions_are_still_there() -> None:
    assert all(path.exists() for path in ABOUT_SEVERAL_HEADERS)


@pytest.mark.parametrize("path", sorted(TESTS.rglob("*.cpp")), ids=lambda p: str(p.relative_to(TESTS)))
def test_the_names_of_gtests_are_claims_in_words(path: Path) -> None:
    names = re.findall(r"^TEST(?:_[FP])?\(\w+, (\w+)\)", path.read_text(), flags=re.MULTILINE)
    assert not [name for name in names if name != name.lower() or "_" not in name]
