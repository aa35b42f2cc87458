"""Writes the stubs of lfdcore._core: python tools/make_stubs.py [FOLDER], by default python/lfdcore/_core.

A folder without __init__.py does not shadow the extension beside it: the import system prefers _core*.so to a namespace
package, and type checkers read the stubs. The extension must be built (cmake --preset dev, or pip install .).
"""

from __future__ import annotations

import ast
import logging
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
COMMITTED = ROOT / "python" / "lfdcore" / "_core"


def make_stubs(folder: Path) -> None:
    """Generates one formatted .pyi a submodule into `folder`, replacing those there."""
    import pybind11_stubgen

    # Default values that are configs have no expression of their own; they become "..." and are no errors.
    logging.getLogger("pybind11_stubgen").setLevel(logging.CRITICAL)
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.pyi"):
        old.unlink()
    with tempfile.TemporaryDirectory() as made:
        pybind11_stubgen.main(["lfdcore._core", "-o", made])
        for stub in sorted(Path(made, "lfdcore", "_core").glob("*.pyi")):
            tree = _Readable().visit(ast.parse(stub.read_text()))
            (folder / stub.name).write_text(ast.unparse(tree) + "\n")
    settings = ("--config", str(ROOT / "pyproject.toml"), "--quiet")
    subprocess.run([sys.executable, "-m", "ruff", "format", *settings, str(folder)], check=True)


_UNSAID = ("__getstate__", "__setstate__", "__eq__", "__ne__")
"""For pickle only, or as every object has them (the generator's signatures of those are not object's)."""


class _Readable(ast.NodeTransformer):
    """What the generator writes, in the types that a reader and `mypy --strict` expect."""

    def visit_ClassDef(self, node: ast.ClassDef) -> ast.AST:
        self.generic_visit(node)
        node.body = [item for item in node.body if not _says_nothing(item)]
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST | None:
        if node.name in _UNSAID:
            return None
        self.generic_visit(node)
        return node

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        """Annotated[X, "[m, 2]"] is X: the docstrings give the shapes, with their meaning."""
        if ast.unparse(node.value) == "typing.Annotated" and isinstance(node.slice, ast.Tuple):
            return self.visit(node.slice.elts[0])
        node.slice = self.visit(node.slice)
        return node

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        """Python's own numbers for what pybind11 converts."""
        plain = {
            "typing.SupportsFloat | typing.SupportsIndex": "float",
            "typing.SupportsInt | typing.SupportsIndex": "int",
        }.get(ast.unparse(node))
        return ast.Name(plain) if plain else self.generic_visit(node)

    def visit_Name(self, node: ast.Name) -> ast.AST:
        return ast.parse("tuple[typing.Any, ...]", mode="eval").body if node.id == "tuple" else node

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        bare = ast.unparse(node) in ("collections.abc.Iterator", "typing.Iterator")
        return ast.parse("collections.abc.Iterator[float]", mode="eval").body if bare else node


def _says_nothing(item: ast.stmt) -> bool:
    return isinstance(item, ast.AnnAssign) and ast.unparse(item.target) == "__hash__"


if __name__ == "__main__":
    make_stubs(Path(sys.argv[1]) if len(sys.argv) > 1 else COMMITTED)
