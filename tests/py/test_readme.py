"""The README is a first page: short, in plain sentences, with one small picture; and no page has odd words."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "README.md").read_text()
PICTURES = re.findall(r"!\[[^\]]*\]\(([^)\s]+)\)|<img[^>]*src=\"([^\"]+)\"", PAGE)
PAGES = [ROOT / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")] + sorted(ROOT.glob("docs/*.md"))
SENTENCE_ENDS = r"(?<!Ch\.)(?<!Sec\.)(?<=[.!?])\**\s+(?=[*\[`A-Z\d])"
STUMBLES = r"\b(foretells?|foretold|foretelling|manieth|taught|told|wherein|whereof|hitherto)\b"


def prose() -> str:
    """The page without code, tables, titles and pictures; a list's items are sentences of their own."""
    text = re.sub(r"^```.*?^```", "", PAGE, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"^(?:\||#|!\[).*$", "", text, flags=re.MULTILINE)
    return re.sub(r"\]\([^)]*\)", "]", re.sub(r"^- ", "\n\n", text, flags=re.MULTILINE))


def sentences() -> list[str]:
    blocks = re.split(r"\n\s*\n", prose())
    parts = [part for block in blocks for part in re.split(SENTENCE_ENDS, block)]
    return [part for part in parts if len(part.split()) > 1]


def test_the_readme_has_at_most_1000_words() -> None:
    assert len(PAGE.split()) <= 1000


def test_the_readme_has_exactly_one_picture_near_the_top() -> None:
    assert len(PICTURES) == 1
    assert PAGE.index("![") < PAGE.index("\n## ")


def test_the_picture_of_the_readme_has_at_most_250_kb() -> None:
    ((path, _),) = PICTURES
    assert (ROOT / path).stat().st_size <= 250_000


def test_at_most_5_percent_of_the_readmes_sentences_have_over_35_words() -> None:
    long = [sentence for sentence in sentences() if len(sentence.split()) > 35]
    assert len(sentences()) > 30
    assert len(long) <= 0.05 * len(sentences()), long


def test_no_code_says_to_people_what_a_reader_stumbles_over() -> None:
    files = sorted((ROOT / "python" / "lfdcore").rglob("*.py"))
    assert [file.name for file in files if re.search(STUMBLES, file.read_text(), flags=re.IGNORECASE)] == []


def test_the_readmes_table_of_drives_stands_in_the_results() -> None:
    """Name by name its numbers are those of docs/results.md, where the command stands that gives them."""
    said, all_results = table_rows(PAGE), table_rows((ROOT / "docs" / "results.md").read_text())
    drives = [row for row in said if len(row) == 5 and row[1].isdigit()]
    assert len(drives) == 5
    assert [row for row in drives if row[1:] not in [other[1:] for other in all_results]] == []


def table_rows(page: str) -> list[list[str]]:
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in page.splitlines() if line[:1] == "|"]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_a_page_uses_no_word_that_a_reader_stumbles_over(page: Path) -> None:
    assert not re.findall(STUMBLES, page.read_text(), flags=re.IGNORECASE)
