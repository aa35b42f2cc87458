#include "lfdcore/simulation/solid_map.hpp"

#include <cstring>
#include <limits>

#include "lfdcore/error.hpp"
#include "lfdcore/grid/distance_field.hpp"

namespace lfdcore {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

OccupancyGrid padded(const OccupancyGrid& grid, bool unknown_is_solid) {
  require_between("resolution of the grid", grid.geometry.resolution, 0.001, 10, "m");
  GridGeometry where = grid.geometry;
  where.width += 2;
  where.height += 2;
  where.origin_x -= where.resolution;
  where.origin_y -= where.resolution;
  OccupancyGrid result(where, unknown_is_solid ? occupied_cell : free_cell);
  auto inner = result.data.block(1, 1, grid.data.rows(), grid.data.cols());
  inner = grid.data.unaryExpr([unknown_is_solid](std::int8_t value) {
    const bool solid = value >= occupied_from || (value < 0 && unknown_is_solid);
    return solid ? occupied_cell : free_cell;
  });
  return result;
}

/// A side of the body from its lower to its upper end, in cells.
struct Side {
  double low_x, low_y, high_y, slope;
};

/// The body's outline in units of cells, for reading off its extent in one row of the grid.
struct Outline {
  std::array<Side, 4> sides;
  double low_y = infinity, high_y = -infinity;

  Outline(const Pose2& pose, const Footprint& footprint, const GridGeometry& where) {
    const auto corners = footprint.corners();
    std::array<Eigen::Vector2d, 4> cells;
    for (int i = 0; i < 4; ++i) {
      cells[i] = (pose * corners[i] - Eigen::Vector2d(where.origin_x, where.origin_y)) / where.resolution;
      low_y = std::min(low_y, cells[i].y());
      high_y = std::max(high_y, cells[i].y());
    }
    for (int i = 0; i < 4; ++i) {
      const auto& [low, high] =
          std::minmax(cells[i], cells[(i + 1) % 4], [](auto& a, auto& b) { return a.y() < b.y(); });
      // A horizontal side gets any slope: its neighbours hold its ends.
      const double rise = high.y() - low.y();
      sides[i] = {low.x(), low.y(), high.y(), rise > 0 ? (high.x() - low.x()) / rise : 0.0};
    }
  }

  /// Smallest and largest x of the body within the closed row [y, y + 1]. The part of a convex body in a row is convex,
  /// so a cell of the row is touched exactly if it meets this interval.
  std::pair<double, double> extent(int y) const {
    double low = infinity, high = -infinity;
    for (const Side& side : sides) {
      const double from = std::max<double>(side.low_y, y), to = std::min<double>(side.high_y, y + 1);
      if (from > to) continue;
      const double x0 = side.low_x + (from - side.low_y) * side.slope;
      const double x1 = side.low_x + (to - side.low_y) * side.slope;
      low = std::min({low, x0, x1});
      high = std::max({high, x0, x1});
    }
    return {low, high};
  }
};

int clamped_floor(double value, int count) {
  return static_cast<int>(std::floor(std::clamp(value, -1.0, count + 0.0)));
}

/// Calls visit(row, first column, last column) for the cells that the body covers; stops when it returns true.
template <class Visit>
bool any_run(const Pose2& pose, const Footprint& footprint, const GridGeometry& where, Visit visit) {
  const Outline outline(pose, footprint, where);
  const int top = std::min(clamped_floor(outline.high_y, where.height), where.height - 1);
  for (int iy = std::max(clamped_floor(outline.low_y, where.height), 0); iy <= top; ++iy) {
    const auto [low, high] = outline.extent(iy);
    const int first = std::max(clamped_floor(low, where.width), 0);
    const int last = std::min(clamped_floor(high, where.width), where.width - 1);
    if (first <= last && visit(iy, first, last)) return true;
  }
  return false;
}

bool leaves(const GridGeometry& where, const Pose2& pose, const Footprint& footprint) {
  for (const auto& corner : footprint.corners())
    if (const auto point = pose * corner; !where.contains(where.cell_at(point.x(), point.y()))) return true;
  return false;
}

}  // namespace

SolidMap::SolidMap(const OccupancyGrid& grid, bool unknown_is_solid)
    : grid_(padded(grid, unknown_is_solid)),
      distance_(distance_field(grid_.occupied_mask(), grid_.geometry.resolution)),
      outside_is_solid_(unknown_is_solid) {}

/// Radius [m] around a point that is surely free: from centre to centre, less half a diagonal at either end.
double SolidMap::free_radius(double x, double y) const {
  const Cell cell = grid_.geometry.cell_at(x, y);
  if (!grid_.geometry.contains(cell)) return 0;
  return distance_(cell.iy, cell.ix) - std::sqrt(2.0) * grid_.geometry.resolution;
}

/// Quick and one-sided: three circles that cover the footprint, side by side, are all free.
bool SolidMap::far(const Pose2& pose, const Footprint& footprint) const {
  const double third = (footprint.front + footprint.rear) / 3;
  const double radius = std::sqrt(third * third / 4 + footprint.half_width * footprint.half_width);
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  for (int i = 0; i < 3; ++i) {
    const double along = (i + 0.5) * third - footprint.rear;
    if (free_radius(pose.x + along * c, pose.y + along * s) <= radius) return false;
  }
  return true;
}

bool SolidMap::hit(const Pose2& pose, const Footprint& footprint) const {
  if (outside_is_solid_ && leaves(grid_.geometry, pose, footprint)) return true;
  return any_run(pose, footprint, grid_.geometry, [&](int iy, int first, int last) {
    return std::memchr(&grid_.data(iy, first), occupied_cell, last - first + 1) != nullptr;
  });
}

std::optional<Eigen::Vector2d> SolidMap::contact_point(const Pose2& pose, const Footprint& footprint) const {
  std::optional<Eigen::Vector2d> nearest;
  const Eigen::Vector2d axle(pose.x, pose.y);
  any_run(pose, footprint, grid_.geometry, [&](int iy, int first, int last) {
    for (int ix = first; ix <= last; ++ix) {
      if (grid_.data(iy, ix) != occupied_cell) continue;
      const Eigen::Vector2d centre = grid_.geometry.centre({ix, iy});
      if (!nearest || (centre - axle).norm() < (*nearest - axle).norm()) nearest = centre;
    }
    return false;
  });
  return nearest;
}

}  // namespace lfdcore
