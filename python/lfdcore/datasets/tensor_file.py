"""Arrays and a JSON header in one file: safetensors whose only metadata entry is JSON with sorted keys.

No pickle; the same model gives the same bytes. Reading refuses what it cannot use with ModelError. The header ends with
its `digest`, the SHA-256 of all before it and of the arrays: safetensors itself does not notice a flipped bit.
"""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from lfdcore.datasets.whole_file import whole_file
from lfdcore.errors import ModelError

_KEY = "lfdcore"  # one entry only: safetensors does not keep the order of several
_DIGEST = ', "digest": "'
"""between the rest of the header and its digest"""
_BROKEN = (SafetensorError, ValueError, OSError, TypeError, AttributeError, RecursionError)
"""What safetensors, its dtypes that NumPy lacks, and JSON raise for files that nobody meant."""
Tensors = dict[str, NDArray[Any]]


def write_tensor_file(
    path: str | os.PathLike[str], kind: str, version: int, header: dict[str, Any], tensors: Tensors
) -> None:
    """Writes the arrays and a JSON header (plus kind and version) to `path`, replacing it in one step.

    ValueError where `path` is a folder, a pipe or a device.
    """
    arrays = {name: np.ascontiguousarray(array) for name, array in tensors.items()}
    said = json.dumps({**header, "format": kind, "version": version}, sort_keys=True, allow_nan=False)[:-1]
    data = save(arrays, metadata={_KEY: f'{said}{_DIGEST}{_digest(said, arrays)}"}}'})
    with whole_file(path, "model") as part:
        part.write_bytes(data)


def is_tensor_file(path: str | os.PathLike[str]) -> bool:
    """True for a file that begins as safetensors do, whatever its name: 8 bytes of length, then that much JSON."""
    path = Path(path)
    if not path.is_file():
        return False
    with path.open("rb") as file:
        head = file.read(9)
    return head[8:] == b"{" and int.from_bytes(head[:8], "little") <= path.stat().st_size - 8


def tensor_file_format(path: str | os.PathLike[str]) -> str:
    """What kind of model a file says it holds. ModelError for one that is no model; OSError if it cannot be opened."""
    _require_regular(path)
    try:
        with safe_open(str(path), framework="numpy") as file:
            header = json.loads((file.metadata() or {}).get(_KEY, "null"))
    except _BROKEN as broken:
        raise ModelError(f"{path} is not a model file or is damaged: {broken}") from broken
    if not isinstance(header, dict) or not isinstance(header.get("format"), str):
        raise ModelError(f"{path} is no model of lfdcore")
    return str(header["format"])


def read_tensor_file(path: str | os.PathLike[str], kind: str, version: int) -> tuple[dict[str, Any], Tensors]:
    """-> header, arrays. ModelError for a file that is truncated, garbled, of another kind or version; OSError if it
    cannot be opened."""
    _require_regular(path)
    try:
        with safe_open(str(path), framework="numpy") as file:
            text = (file.metadata() or {}).get(_KEY, "null")
            header = json.loads(text)
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
    except _BROKEN as broken:
        raise ModelError(f"{path} is not a model file or is damaged: {broken}") from broken
    if not isinstance(header, dict) or header.get("format") != kind:
        raise ModelError(f"{path} does not hold a {kind} model")
    if header.get("version") != version:
        raise ModelError(f"{path} has format version {header.get('version')}, this lfdcore reads version {version}")
    said, _, digest = text.rpartition(_DIGEST)
    if digest != _digest(said, tensors) + '"}':
        raise ModelError(f"{path} is damaged: it is not what was written")
    del header["digest"]
    return header, tensors


def _digest(said: str, tensors: Tensors) -> str:
    digest = hashlib.sha256(said.encode())
    for name in sorted(tensors):
        array = tensors[name]
        digest.update(f"{name} {array.dtype.str} {array.shape};".encode())
        digest.update(array.tobytes())
    return digest.hexdigest()


def _require_regular(path: str | os.PathLike[str]) -> None:
    if not Path(path).is_file() and Path(path).exists():  # a pipe would be waited for
        raise ModelError(f"{path} is no regular file, so no model")
    with Path(path).open("rb"):  # a missing file is the system's own error
        pass
