"""A table of text cells, for a terminal and for the report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

WIDTH = 120
"""Columns of a terminal that a table is laid out for."""


_GAP = "  "


Row = tuple[str, ...]


@dataclass(frozen=True)
class Table:
    """A titled table of text cells; a cell's lines are parted by newlines, the first one being its main figure."""

    title: str
    header: Row
    rows: tuple[Row, ...]
    note: str = ""

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row) != len(self.header):
                raise ValueError(f"a row of '{self.title}' has {len(row)} cells, must have {len(self.header)}: {row}")

    def as_text(self, width: int = WIDTH) -> str:
        """Aligned for a terminal of `width` columns; columns that do not fit come below, with the first one again."""
        lines = [self.header, *self.rows]
        widths = [max(len(part) for line in lines for part in line[k].split("\n")) for k in range(len(self.header))]
        blocks = [_block(lines, widths, columns) for columns in _fitting(widths, width)]
        note = [*wrapped(self.note, width), ""] if self.note else [""]
        return "\n".join([*wrapped(self.title, width), *"\n\n".join(blocks).split("\n"), *note])


def _fitting(widths: Sequence[int], width: int) -> list[list[int]]:
    """Column numbers of each block: the first column and as many more as fit, at least one."""
    blocks: list[list[int]] = []
    for k in range(1, len(widths)):
        used = sum(widths[c] + len(_GAP) for c in blocks[-1]) if blocks else width
        if used + widths[k] <= width:
            blocks[-1].append(k)
        else:
            blocks.append([0, k])
    return blocks or [[0]]


def _block(lines: Sequence[Row], widths: Sequence[int], columns: Sequence[int]) -> str:
    rule = _GAP.join("-" * widths[c] for c in columns)
    head, *rows = ["\n".join(_row(line, widths, columns)) for line in lines]
    return "\n".join([head, rule, *rows])


def _row(line: Row, widths: Sequence[int], columns: Sequence[int]) -> list[str]:
    cells = [line[c].split("\n") for c in columns]
    shown = []
    for part in range(max(map(len, cells))):
        texts = [cell[part] if part < len(cell) else "" for cell in cells]
        texts = [text.rjust(widths[c]) if c else text.ljust(widths[c]) for text, c in zip(texts, columns, strict=True)]
        shown.append(_GAP.join(texts).rstrip())
    return shown


def wrapped(text: str, width: int) -> list[str]:
    """The words of `text` in lines of at most `width` columns; a longer word has a line of its own."""
    lines = [""]
    for word in text.split():
        if lines[-1] and len(lines[-1]) + 1 + len(word) > width:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines
