#include "lfdcore/grid/scan_mapping.hpp"

#include <limits>

#include "lfdcore/grid/cell_walk.hpp"
#include "pose_check.hpp"

namespace lfdcore {

Beam read_beam(double range, double range_min, double range_max) {
  if (range >= range_max) return {range_max, false};
  if (range >= range_min) return {range, true};
  if (range == -std::numeric_limits<double>::infinity()) return {range_min, true};
  return {};
}

void read_beams(std::span<const float> ranges, double range_min, double range_max, std::span<double> lengths,
                std::span<bool> hit) {
  require_range_limits(range_min, range_max);
  require(lengths.size() == ranges.size() && hit.size() == ranges.size(), "lengths and hit must be as many as ranges");
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const Beam beam = read_beam(ranges[i], range_min, range_max);
    lengths[i] = beam.length;
    hit[i] = beam.hit;
  }
}

OccupancyGrid local_grid(const LaserScan& scan, const Pose2& T_base_laser) {
  validate(scan);
  require_pose("T_base_laser", T_base_laser);
  OccupancyGrid grid(local_window(), unknown_cell);
  const auto& [width, height, resolution, origin_x, origin_y] = grid.geometry;
  const auto ray_of = [&](std::size_t beam) {
    const double angle = T_base_laser.yaw + scan.angle(beam);
    return CellRay{(T_base_laser.x - origin_x) / resolution, (T_base_laser.y - origin_y) / resolution, std::cos(angle),
                   std::sin(angle)};
  };
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const Beam beam = read_beam(scan, i);
    if (beam.length > 0)
      walk_cells(ray_of(i), width, height, beam.length / resolution,
                 [&](Cell cell) { grid.data(cell.iy, cell.ix) = free_cell; });
  }
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const Beam beam = read_beam(scan, i);
    if (!beam.hit) continue;
    const CellRay ray = ray_of(i);
    const double x = ray.x + ray.dx * beam.length / resolution, y = ray.y + ray.dy * beam.length / resolution;
    if (x >= 0 && x < width && y >= 0 && y < height)
      grid.data(static_cast<int>(y), static_cast<int>(x)) = occupied_cell;
  }
  return grid;
}

}  // namespace lfdcore
