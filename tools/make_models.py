"""Trains the models that come with the package again: python tools/make_models.py [FOLDER], by default
python/lfdcore/models, and compares them with those that stood there.

Exit code 1 if primitives have other bytes, or if a network has and its validation loss differs by more than TOLERANCE.
Needs the extra 'train'.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from lfdcore.cli.common import Stages, progress_bar
from lfdcore.datasets import open_log
from lfdcore.models import HEATMAPS, NAIVE, PRIMITIVES, SEED
from lfdcore.study.demonstrations import learn_from_demonstrations, learn_heatmaps_from_demonstrations
from lfdcore.study.heatmaps.comparison import learn_naive
from lfdcore.study.study import under
from lfdcore.wheelchair.models import load_model

COMMITTED = Path(__file__).parents[1] / "python" / "lfdcore" / "models"
TOLERANCE = 0.001
"""Of a network's validation loss, in nats a cell, between machines, versions of torch and numbers of threads."""


def train(folder: Path, tell: Stages) -> dict[str, Path]:
    """Demonstrates and learns in `folder` -> where each model lies, by the name of its file in the package."""
    primitives = learn_from_demonstrations(folder, SEED, progress=tell.step("primitives"))
    heatmaps = learn_heatmaps_from_demonstrations(folder, SEED, under(tell, "heatmaps"))
    mazes = [open_log(path) for path in sorted(folder.glob("maze-*.mcap"))]
    naive = learn_naive(folder, mazes, under(tell, "naive"))
    return {PRIMITIVES.name: primitives, HEATMAPS.name: heatmaps, NAIVE.name: naive}


def compare(before: Path, now: Path) -> tuple[str, bool]:
    """What to say of a model that was trained again, and whether it is near enough to the one before."""
    if not before.exists():
        return "new", True
    if before.read_bytes() == now.read_bytes():
        return "the same bytes", True
    losses = [load_model(path).metadata.get("validation_loss") for path in (before, now)]
    if None in losses:
        return "OTHER BYTES", False
    near = abs(losses[1] - losses[0]) <= TOLERANCE
    change = f"other bytes; validation loss {losses[1]:.5f}, before {losses[0]:.5f}"
    return f"{change}: {'within' if near else 'BEYOND'} {TOLERANCE:g}", near


def make_models(committed: Path) -> Iterator[bool]:
    """Trains, says how each model differs from the committed one, replaces that -> whether each is near enough."""
    with tempfile.TemporaryDirectory() as name:
        with progress_bar() as bar:
            made = train(Path(name), Stages(bar))
        for file, path in made.items():
            change, near = compare(committed / file, path)
            print(f"{file}  {path.stat().st_size / 1e3:.0f} kB  {change}")
            (committed / file).write_bytes(path.read_bytes())
            yield near


if __name__ == "__main__":
    sys.exit(0 if all(list(make_models(Path(sys.argv[1]) if len(sys.argv) > 1 else COMMITTED))) else 1)
