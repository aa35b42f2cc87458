// Where two open cells touch at a corner between two blocked ones: the diagonal move there is cut off (F7).
// Private to planning/.
#pragma once

#include "lfdcore/planning/grid_mdp.hpp"

namespace lfdcore::detail {

// Two cells of a 2 x 2 block are open, the two on the other diagonal blocked.
inline bool pinched(const Mask& blocked, Eigen::Index iy, Eigen::Index ix) {
  const bool here = blocked(iy, ix), right = blocked(iy, ix + 1);
  return here != right && blocked(iy + 1, ix) == right && blocked(iy + 1, ix + 1) == here;
}

/// Calls visit(cell) for both open cells of each such place; a cell may come several times.
template <class Visit>
void for_each_pinched(const Mask& blocked, Visit visit) {
  const int height = static_cast<int>(blocked.rows()), width = static_cast<int>(blocked.cols());
  for (int iy = 0; iy + 1 < height; ++iy) {
    for (int ix = 0; ix + 1 < width; ++ix) {
      if (!pinched(blocked, iy, ix)) continue;
      const int open = blocked(iy, ix) ? 1 : 0;
      visit(Cell{ix + open, iy});
      visit(Cell{ix + 1 - open, iy + 1});
    }
  }
}

}  // namespace lfdcore::detail
