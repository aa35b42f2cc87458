#include "lfdcore/primitives/dtw.hpp"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <vector>

#include "dtw_diagonals.hpp"
#include "lfdcore/error.hpp"
#include "series_checks.hpp"

namespace lfdcore {
namespace {

// The window to use; one that covers everything where none is asked for.
int checked_window(const RowMatrix& a, const RowMatrix& b, std::optional<int> window) {
  detail::require_series("a", a);
  detail::require_series("b", b);
  require(a.cols() == b.cols(),
          "a has " + std::to_string(a.cols()) + " dimensions and b has " + std::to_string(b.cols()));
  const int widest = static_cast<int>(std::max(a.rows(), b.rows()));
  if (!window) return widest;
  const auto least = std::abs(a.rows() - b.rows());
  require(*window >= least, "window is " + std::to_string(*window) + " samples, must be at least " +
                                std::to_string(least) + ", the difference of the lengths " + std::to_string(a.rows()) +
                                " and " + std::to_string(b.rows()));
  return std::min(*window, widest);
}

WarpingPath path_through(const RowMatrix& costs) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  std::vector<std::int64_t> backwards;
  Eigen::Index i = costs.rows() - 1, j = costs.cols() - 1;
  for (backwards = {i, j}; i > 0 || j > 0; backwards.insert(backwards.end(), {i, j})) {
    const double diagonal = i > 0 && j > 0 ? costs(i - 1, j - 1) : inf;
    const double up = i > 0 ? costs(i - 1, j) : inf, left = j > 0 ? costs(i, j - 1) : inf;
    const bool straight = diagonal <= up && diagonal <= left;
    if (straight || up <= left) --i;
    if (straight || up > left) --j;
  }
  const Eigen::Map<const WarpingPath> path(backwards.data(), static_cast<Eigen::Index>(backwards.size() / 2), 2);
  return path.colwise().reverse();
}

}  // namespace

DtwResult dtw(const RowMatrix& a, const RowMatrix& b, std::optional<int> window) {
  detail::DtwDiagonals diagonals(a, b, checked_window(a, b, window));
  DtwResult result;
  result.costs.resize(a.rows(), b.rows());
  if (window) result.costs.setConstant(std::numeric_limits<double>::infinity());
  diagonals.fill(result.costs.data());
  result.distance = result.costs(a.rows() - 1, b.rows() - 1);
  result.path = path_through(result.costs);
  return result;
}

double dtw_distance(const RowMatrix& a, const RowMatrix& b, std::optional<int> window) {
  return detail::DtwDiagonals(a, b, checked_window(a, b, window)).distance();
}

}  // namespace lfdcore
