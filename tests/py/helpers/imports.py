"""What a Python file of the project imports."""

import ast
from pathlib import Path


def imported_modules(path: Path) -> set[str]:
    """Whole names that a file imports anywhere, also inside functions and for types: lfdcore.grid,
    lfdcore.grid.read_beams. AssertionError for a relative import."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module:
            assert node.level == 0, f"{path} uses a relative import"
            names |= {f"{node.module}.{alias.name}" for alias in node.names} | {node.module}
        elif isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
    return names
