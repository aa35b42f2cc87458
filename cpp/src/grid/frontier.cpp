#include "lfdcore/grid/frontier.hpp"

#include <algorithm>

namespace lfdcore {
namespace {

// Each cell and its neighbours up to `reach` to both sides along rows, joined by `join`.
template <class Join>
Mask along_rows(const Mask& mask, Eigen::Index reach, Join join) {
  Mask joined = mask;
  for (Eigen::Index shift = 1; shift <= std::min(reach, mask.cols() - 1); ++shift) {
    const Eigen::Index rest = mask.cols() - shift;
    joined.leftCols(rest) = join(joined.leftCols(rest), mask.rightCols(rest));
    joined.rightCols(rest) = join(joined.rightCols(rest), mask.leftCols(rest));
  }
  return joined;
}

template <class Join>
Mask around(const Mask& mask, Eigen::Index reach, Join join) {
  const Mask rows = along_rows(mask, reach, join);
  return along_rows(rows.transpose(), reach, join).transpose();
}

constexpr auto both = [](const auto& a, const auto& b) { return (a && b).eval(); };
constexpr auto either = [](const auto& a, const auto& b) { return (a || b).eval(); };

}  // namespace

Mask open_mask(const Mask& mask, int width) {
  const Eigen::Index reach = width / 2;
  return around(around(mask, reach, both), reach, either);
}

Mask grown_mask(const Mask& mask, int reach) { return around(mask, reach, either); }

Mask edge_of(const Mask& mask) {
  const Mask inside_row = along_rows(mask, 1, both);
  const Mask inside_column = along_rows(mask.transpose(), 1, both).transpose();
  return mask && !(inside_row && inside_column);
}

}  // namespace lfdcore
