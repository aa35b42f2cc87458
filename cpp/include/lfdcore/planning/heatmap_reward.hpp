// Rewards for following a heatmap among obstacles (Sec. 4.5).
#pragma once

#include "lfdcore/grid/grid.hpp"

namespace lfdcore {

/// Sec. 4.5. Defaults: the printed values.
struct HeatmapRewardConfig {
  float obstacle = -100;  ///< on a blocked cell
  float border = -100;    ///< on the outermost ring of cells
};

/// Throws std::invalid_argument for values that are not finite.
void validate(const HeatmapRewardConfig& config);

/// The reward (height, width) of Sec. 4.5: the heatmap, the border over it, blocked cells over both. `blocked`: the
/// obstacles grown by what the chair needs. Throws std::invalid_argument for an empty heatmap, heat outside [0, 1] (or
/// NaN) or shapes that differ.
FloatGrid heatmap_reward(const FloatGrid& heatmap, const Mask& blocked, const HeatmapRewardConfig& config = {});

}  // namespace lfdcore
