"""report.html: needs nothing else, the same bytes for the same input, and cannot be broken by what it shows."""

import base64
import re
from html.parser import HTMLParser

from matplotlib.figure import Figure

from lfdcore.pictures.style import Picture
from lfdcore.study.report.page import Section, report_page
from lfdcore.study.report.table import Table


def picture(height: float = 1.0) -> Picture:
    figure = Figure(figsize=(2, height))
    figure.subplots().plot([0, 1], [1, 0])
    return Picture(figure, 'a "line" <falls>')


def sections() -> list[Section]:
    table = Table("T <1>", ("", "a & b"), (("x", "1.0+-0.2\n[0.8, 1.2]"),), "a note+-")
    return [Section("Part & whole", "one\n\ntwo", [table], [picture()])]


def written(parts: list[Section]) -> str:
    return report_page("A <title>", parts)


def test_the_report_refers_to_nothing_outside_itself() -> None:
    html = written(sections())
    assert html.startswith("<!doctype html>")
    assert not re.search(r"<(script|link|iframe)|https?://|url\(", html)
    assert re.findall(r'src="([^,"]*)', html) == ["data:image/png;base64"]


def test_a_picture_is_a_png_in_the_page_with_its_caption() -> None:
    html = written(sections())
    found = re.search(r'base64,([^"]+)"', html)
    assert found is not None
    assert base64.b64decode(found[1]).startswith(b"\x89PNG")
    assert "<figcaption>a &quot;line&quot; &lt;falls&gt;</figcaption>" in html


def test_the_same_sections_give_the_same_bytes() -> None:
    assert written(sections()) == written(sections())


def test_markup_in_titles_and_cells_is_shown_not_run() -> None:
    html = written(sections())
    for text in ("A &lt;title&gt;", "Part &amp; whole", "T &lt;1&gt;", "a &amp; b"):
        assert text in html


def test_a_cells_first_line_is_its_figure_and_the_rest_stands_small_below() -> None:
    html = written(sections())
    assert "<td>1.0 &plusmn; 0.2<br><small>[0.8, 1.2]</small></td>" in html
    assert "<p>one</p>\n<p>two</p>" in html


def test_the_result_and_what_made_it_stand_before_everything_else() -> None:
    html = report_page("T", sections(), "0 < 17 collisions", "seed 1. Made by: `lfdcore demo`")
    lead, origin = html.index("0 &lt; 17 collisions</p>"), html.index("<code>lfdcore demo</code></p>")
    assert html.index("</h1>") < lead < origin < html.index("<h2>")
    assert "<p class=" not in written([Section("Part")])


def test_a_missed_figure_stands_out() -> None:
    html = written([Section("Part", "", [Table("T", ("", "a"), (("x", "1.2\nMISSED"),))])])
    assert "<td>1.2<br><small><b>MISSED</b></small></td>" in html


def test_every_tag_that_opens_is_closed() -> None:
    class Tags(HTMLParser):
        def __init__(self) -> None:
            super().__init__()
            self.open: list[str] = []

        def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
            if tag not in ("meta", "img", "br"):
                self.open.append(tag)

        def handle_endtag(self, tag: str) -> None:
            assert self.open.pop() == tag

    tags = Tags()
    tags.feed(written(sections()))
    assert tags.open == []
