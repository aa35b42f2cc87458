#include "lfdcore/planning/heatmap_reward.hpp"

#include <string>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

std::string shape_text(Eigen::Index rows, Eigen::Index cols) {
  return std::to_string(rows) + " x " + std::to_string(cols);
}

}  // namespace

void validate(const HeatmapRewardConfig& config) {
  require_finite("obstacle", config.obstacle, "");
  require_finite("border", config.border, "");
}

FloatGrid heatmap_reward(const FloatGrid& heatmap, const Mask& blocked, const HeatmapRewardConfig& config) {
  validate(config);
  const std::string shape = shape_text(heatmap.rows(), heatmap.cols());
  require(heatmap.size() > 0, "heatmap is " + shape + ", must have at least 1 x 1 cells (height x width)");
  require(blocked.rows() == heatmap.rows() && blocked.cols() == heatmap.cols(),
          "blocked is " + shape_text(blocked.rows(), blocked.cols()) + ", must be " + shape +
              " (height x width) as heatmap is");
  require((heatmap >= 0 && heatmap <= 1).all(), "heatmap holds values outside [0, 1] or NaN");
  FloatGrid reward = heatmap;
  reward.row(0) = reward.row(reward.rows() - 1) = config.border;
  reward.col(0) = reward.col(reward.cols() - 1) = config.border;
  return blocked.select(config.obstacle, reward);
}

}  // namespace lfdcore
