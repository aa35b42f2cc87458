#include "lfdcore/grid/distance_field.hpp"

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

constexpr float nowhere = std::numeric_limits<float>::infinity();

void check(const Mask& occupied, double resolution) {
  require_positive("resolution", resolution, "m");
  if (occupied.size() == 0)
    throw std::invalid_argument("occupied is " + std::to_string(occupied.rows()) + " x " +
                                std::to_string(occupied.cols()) + " cells, must be at least 1 x 1");
}

// Cells to the nearest occupied cell of the same column; infinity if there is none.
FloatGrid distance_along_columns(const Mask& occupied) {
  FloatGrid cells = occupied.select(FloatGrid::Zero(occupied.rows(), occupied.cols()), nowhere);
  for (Eigen::Index iy = 1; iy < cells.rows(); ++iy) cells.row(iy) = cells.row(iy).min(cells.row(iy - 1) + 1);
  for (Eigen::Index iy = cells.rows() - 2; iy >= 0; --iy) cells.row(iy) = cells.row(iy).min(cells.row(iy + 1) + 1);
  return cells;
}

// The lower envelope of the parabolas f(v) + (x - v)^2 of one row. Their crossings are rational numbers that no whole x
// comes close to without being equal, so that doubles decide exactly.
class Envelope {
 public:
  explicit Envelope(Eigen::Index width) : vertex_(width), height_(width), from_(width) {}

  // Replaces distances along columns by squared distances [cells^2] in the plane.
  template <class CellRow>
  void lower(CellRow row) {
    count_ = 0;
    for (Eigen::Index x = 0; x < row.size(); ++x)
      if (row(x) != nowhere) add(static_cast<double>(x), static_cast<double>(row(x)) * row(x));
    if (count_ == 0) return;
    std::size_t k = 0;
    for (Eigen::Index x = 0; x < row.size(); ++x) {
      const auto at = static_cast<double>(x);
      while (k + 1 < count_ && from_[k + 1] <= at) ++k;
      row(x) = static_cast<float>(height_[k] + (at - vertex_[k]) * (at - vertex_[k]));
    }
  }

 private:
  void add(double x, double f) {
    double from = -std::numeric_limits<double>::infinity();
    while (count_ > 0) {
      const double v = vertex_[count_ - 1];
      from = ((f + x * x) - (height_[count_ - 1] + v * v)) / (2 * (x - v));
      if (from > from_[count_ - 1]) break;
      --count_;
      from = -std::numeric_limits<double>::infinity();
    }
    vertex_[count_] = x;
    height_[count_] = f;
    from_[count_++] = from;
  }

  std::vector<double> vertex_, height_, from_;
  std::size_t count_ = 0;
};

FloatGrid squared_distance(const Mask& occupied) {
  FloatGrid cells = distance_along_columns(occupied);
  Envelope envelope(cells.cols());
  for (Eigen::Index iy = 0; iy < cells.rows(); ++iy) envelope.lower(cells.row(iy));
  return cells;
}

}  // namespace

FloatGrid distance_field(const Mask& occupied, double resolution) {
  check(occupied, resolution);
  const auto metres = static_cast<float>(resolution);
  // Not Eigen's sqrt(), whose fast variant makes infinity NaN.
  return squared_distance(occupied).unaryExpr([metres](float square) { return std::sqrt(square) * metres; });
}

Mask inflate(const Mask& occupied, double radius, double resolution) {
  check(occupied, resolution);
  require_between("radius", radius, 0, std::numeric_limits<double>::max(), "m");
  // So that 7 cells of 0.05 m are within 0.35 m.
  const double cells = radius / resolution * (1 + 1e-9);
  return squared_distance(occupied).cast<double>() <= cells * cells;
}

}  // namespace lfdcore
