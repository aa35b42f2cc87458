"""The palette: colours that meet in one figure are told apart, also by colour-blind readers, and stand in one file."""

import ast
import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from lfdcore.pictures.style import ALARM, RANKS, TOGETHER

PACKAGE = Path(__file__).parents[3] / "python" / "lfdcore"
LEAST = 17.0
"""Delta E (CIE76) between colours of a figure; about 2.3 is just seen, side by side"""
SIGHTS = {
    "normal": np.eye(3),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
}
"""On linear RGB; Machado, Oliveira and Fernandes (2009), severity 1"""
XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
"""of linear sRGB, D65"""
HEX = re.compile(r"#[0-9a-fA-F]{3,8}\b")
NAMED = re.compile(r"C\d|tab:\w+|red|green|blue|orange|purple|violet|magenta|cyan|yellow")


def linear(colour: str | tuple[float, ...]) -> np.ndarray:
    value = np.array(to_rgb(colour))
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def lab(rgb: np.ndarray) -> np.ndarray:
    share = XYZ @ rgb / (XYZ @ np.ones(3))
    x, y, z = np.where(share > 216 / 24389, np.cbrt(share), (24389 / 27 * share + 16) / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def difference(a: str, b: str, sight: str) -> float:
    one, other = (lab(np.clip(SIGHTS[sight] @ linear(colour), 0, 1)) for colour in (a, b))
    return float(np.linalg.norm(one - other))


def contrast(colour: str | tuple[float, ...]) -> float:
    """With white (WCAG 2)."""
    return float(1.05 / (XYZ[1] @ linear(colour) + 0.05))


def strings(path: Path) -> list[str]:
    """All literals of a file but its docstrings, parts of f-strings among them."""
    tree = ast.parse(path.read_text())
    said = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    nodes = (node for node in ast.walk(tree) if isinstance(node, ast.Constant) and id(node) not in said)
    return [node.value for node in nodes if isinstance(node.value, str)]


def drawing() -> list[Path]:
    files = [path for path in PACKAGE.rglob("*.py") if "matplotlib" in path.read_text()]
    return sorted(path for path in files if path != PACKAGE / "pictures" / "style.py")


def saturation(colour: str) -> float:
    return float(np.hypot(*lab(linear(colour))[1:]))


@pytest.mark.parametrize("sight", SIGHTS)
@pytest.mark.parametrize("figure", TOGETHER)
def test_colours_of_one_figure_are_told_apart(figure: str, sight: str) -> None:
    close = {
        (a, b): difference(a, b, sight) for a, b in combinations(TOGETHER[figure], 2) if difference(a, b, sight) < LEAST
    }
    assert not close


def test_what_colour_blind_readers_confuse_is_seen_as_close() -> None:
    red, green = "#b45000", "#6e7800"
    assert difference(red, green, "normal") > 50 > 3 * difference(red, green, "deuteranopia")


def test_greys_stay_grey_to_everybody() -> None:
    simulated = [SIGHTS[sight] @ linear("#808080") for sight in SIGHTS]
    np.testing.assert_allclose(simulated, [linear("#808080")] * 3, atol=1e-5)


@pytest.mark.parametrize("path", drawing(), ids=lambda p: str(p.relative_to(PACKAGE)))
def test_only_the_palette_names_colours(path: Path) -> None:
    assert [text for text in strings(path) if HEX.search(text) or NAMED.fullmatch(text)] == []


def test_the_page_has_greys_of_its_own_and_no_colour() -> None:
    text = (PACKAGE / "study" / "report" / "page.py").read_text()
    assert all(saturation(colour) < 10 for colour in HEX.findall(text))


def test_small_letters_and_the_palest_line_are_seen_on_white() -> None:
    assert contrast(ALARM) > 4.5
    assert min(contrast(tuple(RANKS(share)[:3])) for share in np.linspace(0, 1, 50)) > 1.5


def test_every_figure_is_made_in_the_style_of_the_house_and_by_the_page() -> None:
    odd = []
    for path in drawing():
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.FunctionDef) and "Figure(" in (text := ast.unparse(node)):
                styled = any(ast.unparse(one) == "styled" for one in node.decorator_list) or "STYLE" in text
                if not styled or "PAGE" not in text:
                    odd.append(f"{path.relative_to(PACKAGE)}: {node.name}")
    assert not odd
