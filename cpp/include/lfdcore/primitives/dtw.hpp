// Dynamic time warping of two series (App. E.4, Alg. 9 as corrected by ERRATA 49; Sakoe and Chiba 1978).
#pragma once

#include <cstdint>
#include <optional>

#include "lfdcore/row_matrix.hpp"

namespace lfdcore {

/// (K, 2): pairs (i, j) of rows that correspond.
using WarpingPath = Eigen::Matrix<std::int64_t, Eigen::Dynamic, 2, Eigen::RowMajor>;

struct DtwResult {
  double distance = 0;  ///< D(m, n): sum of the Euclidean distances along the cheapest path, in the series' unit
  RowMatrix costs;      ///< (m, n) accumulated costs D without their border; inf outside the window
  WarpingPath path;     ///< (K, 2) from (0, 0) to (m - 1, n - 1)
};

/// D_ij = d(a_i, b_j) + min(D_i-1,j-1, D_i-1,j, D_i,j-1) over borders of inf with D_00 = 0, for a (m, D) and b (n, D);
/// d is the Euclidean distance, |x - y| in one dimension. With a window w (Sakoe-Chiba) only |i - j| <= w counts. Among
/// equal predecessors the path prefers (i-1, j-1), then (i-1, j), then (i, j-1). Takes 8 m n bytes. Throws
/// std::invalid_argument for series that are empty, of different D or not finite and within 1e100, and for a window < 0
/// or narrower than |m - n|, which no path can keep to.
DtwResult dtw(const RowMatrix& a, const RowMatrix& b, std::optional<int> window = std::nullopt);

/// D(m, n) alone, the same to the last bit, in O(m + n) memory.
double dtw_distance(const RowMatrix& a, const RowMatrix& b, std::optional<int> window = std::nullopt);

}  // namespace lfdcore
