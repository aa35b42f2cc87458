#include "lfdcore/grid/ray_casting.hpp"

#include <limits>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

struct Axis {
  int step;
  double per_cell, next;  // ray length per cell, and up to the next cell border
};

Axis axis_along(double position, int cell, double direction) {
  if (direction == 0) return {0, infinity, infinity};
  const double border = direction > 0 ? cell + 1 - position : position - cell;
  return {direction > 0 ? 1 : -1, 1 / std::abs(direction), border / std::abs(direction)};
}

}  // namespace

RayCaster::RayCaster(const OccupancyGrid& grid, double range_max)
    : geometry_(grid.geometry), occupied_(grid.occupied_mask()), range_max_(range_max) {
  require_positive("range_max", range_max, "m");
}

float RayCaster::cast_one(const Pose2& T_map_laser, double angle) const {
  const double x = (T_map_laser.x - geometry_.origin_x) / geometry_.resolution;
  const double y = (T_map_laser.y - geometry_.origin_y) / geometry_.resolution;
  Cell cell{static_cast<int>(std::floor(x)), static_cast<int>(std::floor(y))};
  Axis along_x = axis_along(x, cell.ix, std::cos(T_map_laser.yaw + angle));
  Axis along_y = axis_along(y, cell.iy, std::sin(T_map_laser.yaw + angle));
  const double longest = range_max_ / geometry_.resolution;
  double length = 0;
  while (length <= longest && geometry_.contains(cell)) {
    if (occupied_(cell.iy, cell.ix)) return static_cast<float>(length * geometry_.resolution);
    const bool in_x = along_x.next < along_y.next;
    Axis& axis = in_x ? along_x : along_y;
    (in_x ? cell.ix : cell.iy) += axis.step;
    length = axis.next;
    axis.next += axis.per_cell;
  }
  return std::numeric_limits<float>::infinity();
}

void RayCaster::cast(const Pose2& T_map_laser, std::span<const double> angles, std::span<float> ranges) const {
  for (std::size_t beam = 0; beam < ranges.size(); ++beam) ranges[beam] = cast_one(T_map_laser, angles[beam]);
}

}  // namespace lfdcore
