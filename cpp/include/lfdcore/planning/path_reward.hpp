// Rewards for following a path among obstacles (Sec. 3.5, ERRATA 21, F8).
#pragma once

#include "lfdcore/grid/grid.hpp"
#include "lfdcore/path.hpp"

namespace lfdcore {

/// (N, 2): ix, iy
using CellPath = Eigen::Matrix<int, Eigen::Dynamic, 2, Eigen::RowMajor>;

/// Sec. 3.5. Defaults: the printed values.
struct RewardConfig {
  float obstacle = -100;  ///< on an occupied cell
  float border = -100;    ///< on the outermost ring of cells
  double blur_sigma = 2;  ///< of the Gaussian that spreads both around [cells], cut off at 4 sigma; 0: no spreading
  float path_first = 10;  ///< on the path's first cell
  float path_last = 100;  ///< on its last cell; linear in between
};

/// Throws std::invalid_argument for values that are not finite or a blur_sigma outside 0..1000 cells.
void validate(const RewardConfig& config);

/// The cells (N, 2) that a polyline (M, 2) [m, frame of the grid] passes: consecutive ones differ and touch at a side
/// or a corner. Cells outside the grid are left out. Throws std::invalid_argument for points that are not finite or
/// more than 100 000 cells off.
CellPath path_cells(const Path& path, const GridGeometry& grid);

/// The reward (height, width) of Sec. 3.5: obstacles and border blurred with zeros around the grid; the path's
/// cells over that, linearly increasing; obstacles and border over the path. A cell that the path visits twice keeps
/// its later reward. Throws std::invalid_argument for an empty grid or a path cell outside the grid.
FloatGrid path_reward(const Mask& occupied, const CellPath& path, const RewardConfig& config = {});

}  // namespace lfdcore
