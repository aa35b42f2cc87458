// One sweep of DPP over a padded grid, vectorised. Private to planning/.
#pragma once

#include <vector>

namespace lfdcore::detail {

/// A grid of `height` rows of `stride` (a multiple of `lane_padding`) doubles. Blocked cells and padding hold a reward
/// and a value of -1e200 or less.
struct SweepGrid {
  int height = 0, stride = 0;
  const double* reward = nullptr;      // rho
  const double* self_inner = nullptr;  // (stride): how often a cell is its own successor beyond `stay`
  const double* self_outer = nullptr;  // the same for the first and the last row
  double* rows = nullptr;              // workspace of row_workspace(stride) doubles
};

inline constexpr int lane_padding = 8;
/// Values below this belong to blocked cells.
inline constexpr double blocked_value = -1e200, blocked_below = -1e100;

inline int row_workspace(int stride) { return 18 * (stride + 2 * lane_padding); }

/// next(s) = count rho(s) + discount * sum_a w_a y(s'_a) / sum_a w_a with w = 2^y, over the 3 x 3 successors of s.
using Sweep = void(const SweepGrid& grid, const double* y, double discount, double count, double* next);

/// The same sweep for 2, 4 and 8 lanes, as far as this CPU has them, the widest last.
std::vector<Sweep*> sweeps_of_this_cpu();

/// The widest of them.
Sweep sweep_grid;

}  // namespace lfdcore::detail
