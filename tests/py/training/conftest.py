"""Training's tests borrow the drives of wheelchair's, and train one small net for all."""

import pytest


@pytest.fixture(scope="session")
def pairs():
    """Pairs of three drives around a corner and three straight on."""
    from heatmap_drives import around_the_corner, corridor_log
    from lfdcore.training.parts.heatmap_targets import HeatmapTargetConfig, heatmap_pairs

    starts = [(0.0, y, 0.0) for y in (-0.2, 0.0, 0.2)]
    logs = [around_the_corner(start=start, place="L") for start in starts]
    logs += [corridor_log([(5.0, 0.8, 0.0)], start, place="L") for start in starts]
    return heatmap_pairs(logs, HeatmapTargetConfig(spacing=0.2))


@pytest.fixture(scope="session")
def trained(pairs):
    from lfdcore.training.parts.heatmap_net import HeatmapNetConfig, train_heatmap_net

    return train_heatmap_net(pairs, HeatmapNetConfig(width=8, epochs=12, batch=8, learning_rate=1e-2))
