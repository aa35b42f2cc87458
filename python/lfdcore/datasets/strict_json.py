"""JSON whose keys come once and whose numbers are finite: files that people write by hand."""

from __future__ import annotations

import json
from reprlib import Repr
from typing import Any

_SHORT = Repr()


def parse_json(text: str) -> Any:
    """What `text` holds. ValueError for what is no JSON, a key that comes twice, NaN or Infinity; RecursionError where
    it is nested too deep."""
    return json.loads(text, object_pairs_hook=_no_duplicates, parse_constant=_no_constant)


def _no_duplicates(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    keys = [key for key, _ in pairs]
    if len(set(keys)) < len(keys):
        twice = next(key for key in keys if keys.count(key) > 1)
        raise ValueError(f"key {_SHORT.repr(twice)} comes {keys.count(twice)} times")
    return dict(pairs)


def _no_constant(text: str) -> float:
    raise ValueError(f"holds {text}, must be finite")
