#include "lfdcore/grid/distance_field.hpp"

#include <limits>
#include <vector>

namespace lfdcore {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// Lower envelope of parabolas (Felzenszwalb and Huttenlocher 2012): squared distances along one line.
void transform_line(std::vector<double>& line, std::vector<int>& apex, std::vector<double>& from) {
  const int n = static_cast<int>(line.size());
  const std::vector<double> height = line;
  int top = -1;
  for (int q = 0; q < n; ++q) {
    if (height[q] == infinity) continue;
    double start = -infinity;
    for (; top >= 0; --top) {
      const int p = apex[top];
      start = ((height[q] + q * q) - (height[p] + p * p)) / (2.0 * (q - p));
      if (start > from[top]) break;
    }
    if (top < 0) start = -infinity;
    apex[++top] = q;
    from[top] = start;
  }
  if (top < 0) return;
  for (int q = 0, k = 0; q < n; ++q) {
    while (k < top && from[k + 1] < q) ++k;
    line[q] = (q - apex[k]) * (q - apex[k]) + height[apex[k]];
  }
}

}  // namespace

FloatGrid distance_field(const Mask& occupied, double resolution) {
  GridOf<double> squared = occupied.select(GridOf<double>::Zero(occupied.rows(), occupied.cols()), infinity);
  const auto longest = static_cast<std::size_t>(std::max(occupied.rows(), occupied.cols()));
  std::vector<double> line, from(longest);
  std::vector<int> apex(longest);
  for (Eigen::Index ix = 0; ix < squared.cols(); ++ix) {
    line.assign(squared.rows(), 0);
    for (Eigen::Index iy = 0; iy < squared.rows(); ++iy) line[iy] = squared(iy, ix);
    transform_line(line, apex, from);
    for (Eigen::Index iy = 0; iy < squared.rows(); ++iy) squared(iy, ix) = line[iy];
  }
  for (Eigen::Index iy = 0; iy < squared.rows(); ++iy) {
    line.assign(squared.row(iy).begin(), squared.row(iy).end());
    transform_line(line, apex, from);
    for (Eigen::Index ix = 0; ix < squared.cols(); ++ix) squared(iy, ix) = line[ix];
  }
  return (squared.sqrt() * resolution).cast<float>();
}

}  // namespace lfdcore
