#include "lfdcore/planning/grid_mdp.hpp"

#include <string>
#include <utility>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

constexpr Eigen::Index max_cells = Eigen::Index{1} << 28;

std::string shape_text(Eigen::Index rows, Eigen::Index cols) {
  return std::to_string(rows) + " x " + std::to_string(cols);
}

}  // namespace

GridMdp::GridMdp(FloatGrid reward_of_cells, Mask blocked_cells)
    : reward(std::move(reward_of_cells)), blocked(std::move(blocked_cells)) {
  const std::string shape = shape_text(reward.rows(), reward.cols());
  require(reward.size() > 0, "reward is " + shape + ", must have at least 1 x 1 cells (height x width)");
  require(reward.size() <= max_cells, "reward is " + shape + ", must have at most 2^28 cells");
  require(blocked.rows() == reward.rows() && blocked.cols() == reward.cols(),
          "blocked is " + shape_text(blocked.rows(), blocked.cols()) + ", must be " + shape +
              " (height x width) as reward is");
  require(reward.allFinite(), "reward holds NaN or infinity, every cell must be finite");
}

GridMdp::GridMdp(FloatGrid reward_of_cells) : reward(std::move(reward_of_cells)) {
  blocked.setConstant(reward.rows(), reward.cols(), false);
  *this = GridMdp(std::move(reward), std::move(blocked));
}

Cell GridMdp::successor(Cell cell, int action) const {
  const Cell next{cell.ix + action_dx(action), cell.iy + action_dy(action)};
  return contains(next) ? next : cell;
}

bool GridMdp::available(Cell cell, int action) const {
  const Cell next = successor(cell, action);
  if (blocked(cell.iy, cell.ix) || blocked(next.iy, next.ix)) return false;
  return !(blocked(cell.iy, next.ix) && blocked(next.iy, cell.ix));
}

}  // namespace lfdcore
