#include "lfdcore/planning/movement_template.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

// The fan is even in arctan(curvature * 1 m), so that it covers the window alike whatever the limits are.
constexpr int arc_count = 3600;            // even, so that no arc is straight: each way
constexpr double step = 0.01;              // along an arc [m]
constexpr int steps_per_half_circle = 16;  // at least

double orientation_of(double curvature, bool ahead, const MotionLimits& limits) {
  const double left = curvature * (ahead ? limits.max_linear : limits.max_reverse) / limits.max_angular;
  // + 0: straight back is pi, not -pi
  return ahead ? std::atan2(left, 1.0) : std::atan2(0.0 - left, -1.0);
}

// Sums over the arcs through each cell.
struct Sums {
  explicit Sums(const GridGeometry& where) : window(where) {
    length = count = GridOf<double>::Zero(where.height, where.width);
    direction = GridOf<std::complex<double>>::Zero(where.height, where.width);
  }
  void add(Cell cell, std::complex<double> way, double travelled) {
    direction(cell.iy, cell.ix) += way;
    length(cell.iy, cell.ix) += travelled;
    count(cell.iy, cell.ix) += 1;
  }

  GridGeometry window;
  GridOf<std::complex<double>> direction;
  GridOf<double> length, count;
};

// Follows an arc from the origin and adds it once to each cell it passes, with its length up to the middle of the way
// through the cell.
void follow(double curvature, bool ahead, const MotionLimits& limits, Sums& sums) {
  const auto way = std::polar(1.0, orientation_of(curvature, ahead, limits));
  const double bend = std::abs(curvature), end = pi / bend;
  const double pace = std::min(step, end / steps_per_half_circle);
  Cell at{-1, -1};
  double entered = 0, travelled = 0.5 * pace;
  for (; travelled < end; travelled += pace) {
    const double turned = bend * travelled;
    const double x = std::sin(turned) / bend, y = std::copysign((1 - std::cos(turned)) / bend, curvature);
    const Cell next = sums.window.cell_at(ahead ? x : -x, y);
    if (next == at) continue;
    if (at.ix >= 0) sums.add(at, way, 0.5 * (entered + travelled));
    if (!sums.window.contains(next)) return;
    at = next, entered = travelled;
  }
  sums.add(at, way, 0.5 * (entered + end));
}

}  // namespace

double arc_orientation(const Eigen::Vector2d& point, const MotionLimits& limits) {
  validate(limits);
  require_finite("point x", point.x(), "m");
  require_finite("point y", point.y(), "m");
  const double distance = std::hypot(point.x(), point.y());
  require(distance > 0, "point is base_link's origin, through which arcs of all orientations lead");
  return orientation_of(2 * (point.y() / distance) / distance, point.x() >= 0, limits);
}

MovementTemplate::MovementTemplate(const MotionLimits& limits) : limits_(limits) {
  validate(limits);
  Sums sums(local_window());
  for (int i = 0; i < arc_count; ++i) {
    const double angle = pi * ((i + 0.5) / arc_count - 0.5);
    for (const bool ahead : {true, false}) follow(std::tan(angle), ahead, limits, sums);
  }
  orientation_ = sums.direction.unaryExpr([](const auto& sum) { return static_cast<float>(std::arg(sum)); });
  const GridOf<double> mean_length = sums.length / sums.count;
  distance_filter_ = (mean_length / mean_length.maxCoeff()).cast<float>();
}

}  // namespace lfdcore
