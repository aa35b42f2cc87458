"""lfdcore study passing, as a user calls it."""

import json
from pathlib import Path

from calling import run


def test_study_passing_writes_the_same_bytes_again_and_says_its_claims(tmp_path: Path, monkeypatch, capsys) -> None:
    words = ("study", "passing", "--seeds", 2, "--seed", 100, "--demonstrations", 3)
    first, second = tmp_path / "made" / "here", tmp_path / "again"
    code, out, err = run(monkeypatch, capsys, *words, "-o", first, "--processes", 1, "--json")
    said = json.loads(out)
    assert code == 0, err
    assert Path(said["report"]) == first / "report.html"
    assert [aim["wanted"] for aim in said["aims"]] == ["<= 0.6", "0.85 - 1.15", ">= 0.9", "<= 0.6", "<= 1.6"]
    assert "lfdcore study passing -o out --seeds 2 --demonstrations 3 --seed 100" in (first / "report.html").read_text()
    code, out, err = run(monkeypatch, capsys, *words, "-o", second, "--processes", 2)
    assert code == 0, err
    assert "Figures to reach, novel rectangles (n = 2 seeds, 100..101)" in out
    written, again = ({file.name: file.read_bytes() for file in folder.iterdir()} for folder in (first, second))
    assert written == again
    assert set(written) == {"report.html", "figures.json", "demonstrations.png", "observations.png", "distance.png"}


def test_study_passing_refuses_what_is_out_of_bounds(tmp_path: Path, monkeypatch, capsys) -> None:
    for words in (("--seeds", 0), ("--demonstrations", 1), ("--seed", -1)):
        code, _, err = run(monkeypatch, capsys, "study", "passing", "-o", tmp_path / "none", *words)
        assert code == 2
        assert str(words[0]) in err
    assert not (tmp_path / "none").exists()
