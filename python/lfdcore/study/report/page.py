"""One self-contained report.html: tables, pictures, how to repeat it."""

from __future__ import annotations

import base64
import re
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from lfdcore.pictures.style import ALARM, LEARNED, Picture, png
from lfdcore.study.report.table import Table

STYLE = (
    f":root {{ --result: {LEARNED}; --missed: {ALARM}; }}"
    + """
body { font: 16px/1.5 "DejaVu Sans", system-ui, sans-serif; color: #1f2328; max-width: 1200px; margin: 2rem auto;
  padding: 0 1rem; }
h1 { font-size: 1.7rem; } h2 { font-size: 1.25rem; margin-top: 2.2rem; border-bottom: 1px solid #d0d7de; }
p { max-width: 52rem; }
table { border-collapse: collapse; font-size: .84rem; line-height: 1.35; margin: 1.2rem 0 .3rem; }
th, td { padding: .3rem .55rem; border-bottom: 1px solid #e4e7eb; text-align: right; white-space: nowrap;
  vertical-align: top; font-variant-numeric: tabular-nums; }
th { background: #f4f6f8; } th:first-child, td:first-child { text-align: left; }
caption { text-align: left; font-weight: 600; padding: .3rem 0; white-space: nowrap; } small { color: #59636e; }
small b { color: var(--missed); } th small { font-size: .92em; color: #3d444d; }
code { font: .92em "DejaVu Sans Mono", monospace; overflow-wrap: anywhere; }
.lead { font-weight: 600; border-left: 4px solid var(--result); padding: .1rem 0 .1rem .8rem; }
.note { color: #59636e; font-size: .84rem; margin-top: .2rem; } .wide { overflow-x: auto; }
figure { margin: 1.6rem 0; } figcaption { color: #3d444d; font-size: .88rem; max-width: 58rem; }
img { max-width: 100%; height: auto; }
@media (max-width: 600px) { caption, th:first-child, td:first-child { white-space: normal; }
  th:first-child, td:first-child { position: sticky; left: 0; min-width: 7rem; } td:first-child { background: #fff; } }
@media print { body { max-width: none; margin: 0; } figure, table { break-inside: avoid; } }
"""
)


SIGNS = {"+-": " &plusmn; ", "-&gt;": "&rarr;", "&gt;=": "&ge;", "&lt;=": "&le;", "MISSED": "<b>MISSED</b>"}
"""What tables write in ASCII, for the terminal, and its sign in a page."""


@dataclass(frozen=True)
class Section:
    """A part of the report; empty lines in `text` part paragraphs."""

    title: str
    text: str = ""
    tables: Sequence[Table] = ()
    pictures: Sequence[Picture] = ()


def _cell(text: str) -> str:
    """A cell's first line large, further ones small."""
    html = escape(text)
    for typed, sign in SIGNS.items():
        html = html.replace(typed, sign)
    first, *more = html.split("\n")
    return first + "".join(f"<br><small>{line}</small>" for line in more)


def _code(text: str) -> str:
    return re.sub("`([^`]+)`", r"<code>\1</code>", escape(text))


def _table(table: Table) -> str:
    head = "".join(f"<th>{_cell(cell)}</th>" for cell in table.header)
    body = "".join("<tr>" + "".join(f"<td>{_cell(cell)}</td>" for cell in row) + "</tr>\n" for row in table.rows)
    note = f'<p class="note">{_cell(table.note)}</p>' if table.note else ""
    caption = f"<caption>{escape(table.title)}</caption>"
    return f'<div class="wide"><table>{caption}\n<tr>{head}</tr>\n{body}</table></div>{note}\n'


def _picture(picture: Picture) -> str:
    caption, data = escape(picture.caption), base64.b64encode(png(picture.figure)).decode()
    image = f'<img alt="{caption}" src="data:image/png;base64,{data}">'
    return f"<figure>{image}<figcaption>{caption}</figcaption></figure>\n"


def _section(section: Section) -> str:
    text = "".join(f"<p>{escape(part)}</p>\n" for part in section.text.split("\n\n") if part)
    tables, pictures = "".join(map(_table, section.tables)), "".join(map(_picture, section.pictures))
    return f"<h2>{escape(section.title)}</h2>\n{text}{tables}{pictures}"


def report_page(title: str, sections: Sequence[Section], lead: str = "", origin: str = "") -> str:
    """One HTML file that needs nothing else. The same arguments give the same text.

    Below the title stand `lead`, the result in a sentence or two, and small `origin`, what made it; what stands
    between backticks is code.
    """
    parts = (f'<p class="{kind}">{_code(text)}</p>\n' for kind, text in (("lead", lead), ("note", origin)) if text)
    body = "".join([*parts, *map(_section, sections)])
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(title)}</title><style>{STYLE}</style></head>\n<body><h1>{escape(title)}</h1>\n"
        f"{body}</body></html>\n"
    )
