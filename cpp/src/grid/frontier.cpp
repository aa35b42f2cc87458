#include "lfdcore/grid/frontier.hpp"

#include <algorithm>

namespace lfdcore {
namespace {

// Joins each cell of a row with those of another row that are `shift` cells to its right and to its left.
template <class Join>
void join_shifted(bool* to, const bool* from, Eigen::Index cells, Eigen::Index shift, Join join) {
  for (Eigen::Index i = 0; i < cells - shift; ++i) to[i] = join(to[i], from[i + shift]);
  for (Eigen::Index i = shift; i < cells; ++i) to[i] = join(to[i], from[i - shift]);
}

// Each cell and its neighbours up to `reach` to both sides along rows, joined by `join`.
template <class Join>
Mask along_rows(const Mask& mask, Eigen::Index reach, Join join) {
  Mask joined = mask;
  for (Eigen::Index row = 0; row < mask.rows(); ++row)
    for (Eigen::Index shift = 1; shift <= reach; ++shift)
      join_shifted(joined.row(row).data(), mask.row(row).data(), mask.cols(), shift, join);
  return joined;
}

template <class Join>
Mask along_columns(const Mask& mask, Eigen::Index reach, Join join) {
  Mask joined = mask;
  for (Eigen::Index row = 0; row < mask.rows(); ++row) {
    const Eigen::Index last = std::min(row + reach, mask.rows() - 1);
    for (Eigen::Index other = std::max<Eigen::Index>(row - reach, 0); other <= last; ++other)
      join_shifted(joined.row(row).data(), mask.row(other).data(), mask.cols(), 0, join);
  }
  return joined;
}

template <class Join>
Mask around(const Mask& mask, Eigen::Index reach, Join join) {
  return along_columns(along_rows(mask, reach, join), reach, join);
}

constexpr auto both = [](bool a, bool b) -> bool { return a & b; };
constexpr auto either = [](bool a, bool b) -> bool { return a | b; };

}  // namespace

Mask open_mask(const Mask& mask, int width) {
  const Eigen::Index reach = width / 2;
  return around(around(mask, reach, both), reach, either);
}

Mask grown_mask(const Mask& mask, int reach) { return around(mask, reach, either); }

Mask edge_of(const Mask& mask) { return mask && !(along_rows(mask, 1, both) && along_columns(mask, 1, both)); }

}  // namespace lfdcore
