"""The border between lfdcore._core and Python: facades that name all of it, stubs that say what it is."""

import ast
import importlib
import importlib.util
import pkgutil
import sys
from pathlib import Path

import pytest

import lfdcore
from lfdcore import _core

ROOT = Path(__file__).parents[2]
SUBMODULES = sorted(name for name in vars(_core) if isinstance(getattr(_core, name), type(_core)))
COMMITTED = ROOT / "python" / "lfdcore" / "_core"


def public(module: object) -> set[str]:
    return {name for name in vars(module) if not name.startswith("_")}


def test_every_submodule_of_the_core_has_a_facade() -> None:
    there = {info.name for info in pkgutil.iter_modules(lfdcore.__path__)}
    assert set(SUBMODULES) <= there


@pytest.mark.parametrize("name", SUBMODULES)
def test_a_facade_exports_all_that_its_submodule_has_and_nothing_else(name: str) -> None:
    facade, core = importlib.import_module(f"lfdcore.{name}"), getattr(_core, name)
    assert set(facade.__all__) == public(core)
    assert all(getattr(facade, exported) is getattr(core, exported) for exported in facade.__all__)


@pytest.mark.parametrize("name", SUBMODULES)
def test_every_public_name_of_the_core_has_a_docstring(name: str) -> None:
    core = getattr(_core, name)
    assert not [public_name for public_name in public(core) if not getattr(core, public_name).__doc__]


def test_the_folder_of_stubs_does_not_shadow_the_extension() -> None:
    assert Path(_core.__file__).suffix in {".so", ".pyd"}
    assert not (COMMITTED / "__init__.py").exists()


def test_the_stubs_are_installed_with_the_package() -> None:
    assert {path.stem for path in Path(lfdcore.__path__[0], "_core").glob("*.pyi")} == {"__init__", *SUBMODULES}


@pytest.mark.skipif(
    sys.version_info[:2] != (3, 11), reason="the committed stubs were made with Python 3.11, whose signatures they show"
)
def test_the_committed_stubs_are_those_of_this_core(tmp_path: Path) -> None:
    spec = importlib.util.spec_from_file_location("make_stubs", ROOT / "tools" / "make_stubs.py")
    assert spec is not None and spec.loader is not None
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    tool.make_stubs(tmp_path)
    made = {path.name: ast.dump(ast.parse(path.read_text())) for path in tmp_path.glob("*.pyi")}
    committed = {path.name: ast.dump(ast.parse(path.read_text())) for path in COMMITTED.glob("*.pyi")}
    assert made.keys() == committed.keys()
    stale = [name for name in made if made[name] != committed[name]]
    assert not stale, f"{stale} are not up to date: run `make stubs` and commit the result"
