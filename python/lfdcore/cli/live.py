"""Facts that change while one looks: in a terminal a table in one place, else a line now and then."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from rich.table import Table

EveryOption = Annotated[
    float | None,
    typer.Option(
        min=0.05, max=3600, help="Seconds between two looks. Default: a tenth in a terminal, else lines now and then."
    ),
]
BAR = 15
"""characters of a bar, odd: its middle is 0"""


@contextmanager
def live_facts() -> Iterator[Callable[[Mapping[str, str]], None]]:
    """-> what shows facts by name, the newest in the place of those before. The last ones stay."""
    if not _is_terminal():
        yield lambda facts: typer.echo("  ".join(f"{name} {value}" for name, value in facts.items() if value))
        return
    from rich.live import Live

    with Live(auto_refresh=False) as live:
        yield lambda facts: live.update(_table(facts), refresh=True)


def usual_interval(line: float) -> float:
    """[s] between two looks: in a terminal a tenth, else `line`, between two lines"""
    return 0.1 if _is_terminal() else line


def _is_terminal() -> bool:
    return sys.stdout is not None and sys.stdout.isatty()  # None: it was closed before we began


def bar(share: float) -> str:
    """Of a number in [-1, 1], 0 in its middle: '·····█████·····'"""
    half = BAR // 2
    filled = round(abs(share) * half)
    places = range(-half, half + 1)
    ends = (0, filled) if share >= 0 else (-filled, 0)
    return "".join("|" if place == 0 else "█" if ends[0] <= place <= ends[1] else "·" for place in places)


def _table(facts: Mapping[str, str]) -> Table:
    from rich.table import Table
    from rich.text import Text

    table = Table.grid(padding=(0, 2))
    table.add_column(no_wrap=True, style="bold")
    table.add_column(overflow="fold")
    for name, value in facts.items():
        table.add_row(name, Text(value))
    return table
