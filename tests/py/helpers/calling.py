"""Calls the command line in this process, as a user does."""

import sys

import pytest

from lfdcore.cli import main as command_line


def run(monkeypatch, capsys, *words) -> tuple[int, str, str]:
    """-> exit code, standard output, standard error"""
    monkeypatch.setattr(sys, "argv", ["lfdcore", *map(str, words)])
    monkeypatch.setenv("COLUMNS", "200")
    capsys.readouterr()
    with pytest.raises(SystemExit) as end:
        command_line.main()
        raise SystemExit(0)
    out, err = capsys.readouterr()
    return int(end.value.code or 0), out, err
