"""The part of a page of docs/ that a tool makes: between `<!-- made by tools/NAME.py -->` and `<!-- end -->`."""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]


def renew(page: str, tool: str, part: str) -> None:
    """Writes `part` into docs/`page` for tools/`tool`. With --check on the command line it writes nothing, and ends the
    process with an error where the page is out of date."""
    path = ROOT / "docs" / page
    old = path.read_text()
    new = _renewed(old, f"<!-- made by tools/{tool} -->", "<!-- end -->", part)
    if new == old:
        return
    if "--check" in sys.argv:
        sys.exit(f"docs/{page} is out of date: run python tools/{tool}")
    path.write_text(new)


def _renewed(page: str, begin: str, end: str, part: str) -> str:
    before, rest = page.split(begin)
    return f"{before}{begin}\n\n{part}\n\n{end}{rest.split(end)[1]}"
