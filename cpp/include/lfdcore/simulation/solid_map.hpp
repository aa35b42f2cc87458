// A map as a rectangular body feels it: which cells are solid, and whether the body touches one, exactly.
#pragma once

#include <optional>

#include "lfdcore/grid/grid.hpp"

namespace lfdcore {

class SolidMap {
 public:
  /// Occupied cells are solid squares. If `unknown_is_solid`, so are the unknown cells and all that lies outside the
  /// grid; else both are free.
  SolidMap(const OccupancyGrid& grid, bool unknown_is_solid);

  /// The map with a border of one cell for the outside, every cell 0 or 100: what a LIDAR in it sees.
  const OccupancyGrid& grid() const { return grid_; }

  /// True if the footprint of a body at `pose` and a solid square share a point (edges belong to both).
  bool touches(const Pose2& pose, const Footprint& footprint) const {
    return !far(pose, footprint) && hit(pose, footprint);
  }

  /// A point [m] of the touched solid cell (its centre) that is nearest to the axle, if any.
  std::optional<Eigen::Vector2d> contact_point(const Pose2& pose, const Footprint& footprint) const;

 private:
  bool far(const Pose2& pose, const Footprint& footprint) const;
  bool hit(const Pose2& pose, const Footprint& footprint) const;
  double free_radius(double x, double y) const;

  OccupancyGrid grid_;
  FloatGrid distance_;
  bool outside_is_solid_;
};

}  // namespace lfdcore
