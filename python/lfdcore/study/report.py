"""One self-contained report.html: tables, pictures, how to repeat it."""

from __future__ import annotations

import base64
import io
import json
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

from matplotlib.figure import Figure

from lfdcore.study.tables import Table

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #1f2328; max-width: 1180px; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.7rem; } h2 { font-size: 1.25rem; margin-top: 2.2rem; border-bottom: 1px solid #d0d7de; }
table { border-collapse: collapse; font-size: .88rem; margin: 1rem 0 .3rem; }
th, td { padding: .3rem .7rem; border-bottom: 1px solid #e4e7eb; text-align: right; white-space: nowrap; }
th { background: #f4f6f8; } th:first-child, td:first-child { text-align: left; }
caption { text-align: left; font-weight: 600; padding: .3rem 0; }
.note { color: #59636e; font-size: .85rem; } .wide { overflow-x: auto; }
figure { margin: 1.2rem 0; } figcaption { color: #59636e; font-size: .88rem; } img { max-width: 100%; height: auto; }
"""


@dataclass(frozen=True)
class Picture:
    """A figure and what it shows."""

    figure: Figure
    caption: str


@dataclass(frozen=True)
class Section:
    """A part of the report."""

    title: str
    text: str = ""
    tables: Sequence[Table] = ()
    pictures: Sequence[Picture] = ()


def _png(figure: Figure) -> str:
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=110, metadata={"Software": None})
    return base64.b64encode(data.getvalue()).decode()


def _table(table: Table) -> str:
    head = "".join(f"<th>{escape(cell)}</th>" for cell in table.header)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in table.rows)
    note = f'<p class="note">{escape(table.note)}</p>' if table.note else ""
    caption = f"<caption>{escape(table.title)}</caption>"
    return f'<div class="wide"><table>{caption}<tr>{head}</tr>{body}</table></div>{note}'.replace("+-", " &plusmn; ")


def _section(section: Section) -> str:
    text = "".join(f"<p>{escape(part)}</p>" for part in section.text.split("\n\n") if part)
    tables = "".join(map(_table, section.tables))
    pictures = "".join(
        f'<figure><img alt="{escape(p.caption)}" src="data:image/png;base64,{_png(p.figure)}">'
        f"<figcaption>{escape(p.caption)}</figcaption></figure>"
        for p in section.pictures
    )
    return f"<h2>{escape(section.title)}</h2>{text}{tables}{pictures}"


def write_report(path: Path, title: str, sections: Sequence[Section]) -> Path:
    """Writes one HTML file that needs nothing else -> its path. The same sections give the same bytes."""
    body = "".join(map(_section, sections))
    path.write_text(
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        f"<style>{STYLE}</style></head><body><h1>{escape(title)}</h1>{body}</body></html>\n"
    )
    return path


def write_figures(path: Path, rows: Sequence[dict[str, object]]) -> Path:
    """Writes all figures of all runs as JSON -> its path."""
    path.write_text(json.dumps(list(rows), indent=1) + "\n")
    return path
