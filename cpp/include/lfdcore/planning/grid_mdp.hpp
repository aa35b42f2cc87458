// The grid world as a Markov decision process (App. D.2): a state a cell, 9 deterministic moves, reward on arrival.
#pragma once

#include "lfdcore/grid/grid.hpp"

namespace lfdcore {

/// Actions 0..8 run row-major over (dy, dx) in (-1, 0, 1)^2; number 4 stays. Ties go to the lowest index (F7).
inline constexpr int action_count = 9, stay_action = 4;

inline int action_dx(int action) { return action % 3 - 1; }
inline int action_dy(int action) { return action / 3 - 1; }

/// Rewards and hard obstacles on a grid.
struct GridMdp {
  FloatGrid reward;  ///< (height, width): r(s'), gained on arriving in (or staying on) a cell
  Mask blocked;      ///< (height, width): cells that no move enters

  GridMdp() = default;
  /// Throws std::invalid_argument for no cells or more than 2^28, shapes that differ or a reward that is not finite.
  GridMdp(FloatGrid reward_of_cells, Mask blocked_cells);
  /// Nothing blocked: obstacles are soft, only their rewards keep a plan away from them (ERRATA 20).
  explicit GridMdp(FloatGrid reward_of_cells);

  int height() const { return static_cast<int>(reward.rows()); }
  int width() const { return static_cast<int>(reward.cols()); }
  bool contains(Cell c) const { return c.ix >= 0 && c.iy >= 0 && c.ix < width() && c.iy < height(); }

  /// s'(s, a): the neighbour, or s itself where the move would leave the grid (ERRATA 15).
  Cell successor(Cell cell, int action) const;

  /// Whether a move can be made: not out of or into a blocked cell, nor diagonally between two blocked cells (F7).
  bool available(Cell cell, int action) const;
};

}  // namespace lfdcore
