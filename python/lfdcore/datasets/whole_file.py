"""Files that are replaced in one step: a reader sees the old one or the new one, never a part."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def whole_file(path: str | os.PathLike[str], what: str) -> Iterator[Path]:
    """A path beside `path` to write `what` (a noun) to. It becomes `path` when the block ends, and is gone where the
    block fails.

    ValueError where `path` is a folder, a pipe or a device; OSError that names `path`.
    """
    target = Path(path)
    if target.exists() and not target.is_file():
        raise ValueError(f"{target}: exists and is no regular file, so no {what} is written there")
    part = target.with_name(f"{target.name}.{os.getpid()}.part")  # of this process: another may write there too
    try:
        yield part
        os.replace(part, target)
    except OSError as failed:  # a full disk names no file, others name the part
        raise OSError(failed.errno, failed.strerror, str(target)) from failed
    finally:
        part.unlink(missing_ok=True)
