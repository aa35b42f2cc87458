// Obstacles as the points that a LIDAR saw, and how far a rectangular body is from them: exact, without rasterising.
#pragma once

#include "lfdcore/geometry.hpp"
#include "lfdcore/path.hpp"

namespace lfdcore {

class ObstaclePoints {
 public:
  ObstaclePoints() = default;
  /// Points (M, 2) [m] in any one frame; rows that are not finite are refused with std::invalid_argument.
  explicit ObstaclePoints(Path points);

  const Path& points() const { return points_; }

  /// True if any point lies inside (or on) the footprint of a body at `pose` (same frame as the points).
  bool collides(const Pose2& pose, const Footprint& footprint) const;

  /// Distance [m] from the footprint's edge to the nearest point outside it; 0 if one lies inside; infinity if none.
  double clearance(const Pose2& pose, const Footprint& footprint) const;

 private:
  Path points_ = Path(0, 2);
};

}  // namespace lfdcore
