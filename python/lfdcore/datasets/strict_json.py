"""JSON whose keys come once and whose numbers are finite: of files that people write by hand, and for machines."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from reprlib import Repr
from typing import Any

import numpy as np

_SHORT = Repr()


def parse_json(text: str) -> Any:
    """What `text` holds. ValueError for what is no JSON, a key that comes twice, NaN or Infinity; RecursionError where
    it is nested too deep."""
    return json.loads(text, object_pairs_hook=_no_duplicates, parse_constant=_no_constant)


def plain_json(value: Any) -> Any:
    """In JSON's values, at any depth. What is not a finite number becomes None: JSON has no NaN."""
    if isinstance(value, Mapping):
        return {name: plain_json(one) for name, one in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain_json(value.tolist())
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [plain_json(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _no_duplicates(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    keys = [key for key, _ in pairs]
    if len(set(keys)) < len(keys):
        twice = next(key for key in keys if keys.count(key) > 1)
        raise ValueError(f"key {_SHORT.repr(twice)} comes {keys.count(twice)} times")
    return dict(pairs)


def _no_constant(text: str) -> float:
    raise ValueError(f"holds {text}, must be finite")
