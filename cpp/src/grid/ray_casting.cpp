#include "lfdcore/grid/ray_casting.hpp"

#include <cmath>
#include <limits>
#include <string>

#include "lfdcore/error.hpp"
#include "lfdcore/grid/cell_walk.hpp"
#include "pose_check.hpp"

namespace lfdcore {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr int longest_side = 255;

// Side of the largest square without an occupied cell that extends from each cell towards (step_x, step_y); 0 in
// occupied cells. Nothing is occupied beyond the map.
std::vector<std::uint8_t> free_sides(const OccupancyGrid& grid, int step_x, int step_y) {
  const int width = grid.geometry.width, height = grid.geometry.height;
  std::vector<std::uint8_t> sides(static_cast<std::size_t>(width) * height);
  std::vector<std::uint8_t> next_row(width, longest_side);
  for (int j = 0; j < height; ++j) {
    const int iy = step_y > 0 ? height - 1 - j : j;
    int beside = longest_side, across = longest_side;
    for (int i = 0; i < width; ++i) {
      const int ix = step_x > 0 ? width - 1 - i : i;
      const int ahead = next_row[ix];
      const int side = grid.occupied({ix, iy}) ? 0 : std::min(std::min({beside, ahead, across}) + 1, longest_side);
      across = ahead;
      beside = side;
      next_row[ix] = sides[static_cast<std::size_t>(iy) * width + ix] = static_cast<std::uint8_t>(side);
    }
  }
  return sides;
}

// Components this small do not leave a cell within any map; as 0 they cannot overflow when inverted.
double flushed(double component) { return std::abs(component) < 1e-30 ? 0.0 : component; }

}  // namespace

RayCaster::RayCaster(const OccupancyGrid& grid, double range_max) : geometry_(grid.geometry), range_max_(range_max) {
  require_positive("range_max", range_max, "m");
  reach_ = range_max / geometry_.resolution;
  for (int quadrant = 0; quadrant < 4; ++quadrant)
    free_sides_[quadrant] = free_sides(grid, quadrant & 1 ? -1 : 1, quadrant & 2 ? -1 : 1);
}

void RayCaster::cast(const Pose2& T_map_laser, std::span<const double> angles, std::span<float> ranges) const {
  require(angles.size() == ranges.size(), "ranges must be as many as angles");
  require_pose("T_map_laser", T_map_laser);
  const double x = (T_map_laser.x - geometry_.origin_x) / geometry_.resolution;
  const double y = (T_map_laser.y - geometry_.origin_y) / geometry_.resolution;
  for (std::size_t i = 0; i < angles.size(); ++i) {
    const double angle = T_map_laser.yaw + angles[i];
    if (!std::isfinite(angle)) require_finite("heading of beam " + std::to_string(i), angle, "rad");
    const double cells = cast_one(x, y, flushed(std::cos(angle)), flushed(std::sin(angle)));
    ranges[i] = static_cast<float>(cells * geometry_.resolution);
  }
}

double RayCaster::cast_one(double x, double y, double dx, double dy) const {
  const int width = geometry_.width, height = geometry_.height;
  const RaySpan span = clip({x, y, dx, dy}, width, height, reach_);
  if (!(span.from <= span.to)) return infinity;
  const bool left = dx < 0, down = dy < 0;
  const std::uint8_t* sides = free_sides_[left + 2 * down].data();
  const double per_x = dx == 0 ? infinity : 1 / dx, per_y = dy == 0 ? infinity : 1 / dy;
  double t = span.from;
  int ix = static_cast<int>(std::clamp(x + t * dx, 0.0, width - 1.0));
  int iy = static_cast<int>(std::clamp(y + t * dy, 0.0, height - 1.0));
  while (t <= span.to) {
    const int side = sides[index(ix, iy)];
    if (side == 0) return t;
    // The square's far edges, and the cells at its end: the edge that is met first is crossed.
    const int edge_x = left ? ix - side + 1 : ix + side, edge_y = down ? iy - side + 1 : iy + side;
    const double t_x = (edge_x - x) * per_x, t_y = (edge_y - y) * per_y;
    if (t_x < t_y) {
      t = t_x;
      const int within = static_cast<int>(y + t * dy);
      iy = down ? std::clamp(within, edge_y, iy) : std::clamp(within, iy, edge_y - 1);
      ix = left ? edge_x - 1 : edge_x;
    } else {
      t = t_y;
      const int within = static_cast<int>(x + t * dx);
      ix = left ? std::clamp(within, edge_x, ix) : std::clamp(within, ix, edge_x - 1);
      iy = down ? edge_y - 1 : edge_y;
    }
    if (ix < 0 || ix >= width || iy < 0 || iy >= height) return infinity;
  }
  return infinity;
}

}  // namespace lfdcore
