"""Three trained models that come with the package, each learned from simulated demonstrations of seed 1.

PRIMITIVES (Ch. 3): three drives of an expert through a furnished home, unassisted (Sec. 3.5).
HEATMAPS (Ch. 4): 72 drives of eight able drivers with DWA through two mazes (Sec. 4.2).
NAIVE: the network of Sec. 4.6.2, from the same 72 drives. It predicts and drives nothing.

`lfdcore.wheelchair.models.load_model` reads each. How they are made again: docs/models.md.
"""

from pathlib import Path

SEED = 1
"""Of the demonstrations."""
_FOLDER = Path(__file__).parent
PRIMITIVES = _FOLDER / "primitives.safetensors"
HEATMAPS = _FOLDER / "heatmaps.safetensors"
NAIVE = _FOLDER / "naive.safetensors"
