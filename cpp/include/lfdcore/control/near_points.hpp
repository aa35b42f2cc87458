// The obstacle points that a moving body may come near to, laid out for thousands of exact distance queries.
#pragma once

#include <limits>
#include <vector>

#include "lfdcore/geometry.hpp"
#include "lfdcore/grid/obstacle_points.hpp"

namespace lfdcore {

/// Signed distance [m] from a point in base_link to the footprint's edge: negative inside.
inline double signed_distance(double x, double y, const Footprint& footprint) {
  const double beyond_x = std::max(x - footprint.front, -footprint.rear - x);
  const double beyond_y = std::abs(y) - footprint.half_width;
  const double outside = std::hypot(std::max(beyond_x, 0.0), std::max(beyond_y, 0.0));
  return outside + std::min(std::max(beyond_x, beyond_y), 0.0);
}

/// A subset of ObstaclePoints, each with the least signed distance [m] that it must keep from the footprint.
/// Keeps its memory between calls of gather(): no allocation once it has seen the largest set.
class NearPoints {
 public:
  /// Takes the points (in base_link) within `radius` [m] of the axle, each with the distance 0 to keep.
  void gather(const ObstaclePoints& obstacles, double radius);

  /// From now on each point must keep `distance` [m], but no more than it has now (body at the origin).
  void keep(double distance, const Footprint& footprint);

  /// Least of (signed distance - distance to keep) [m] over the points, for a body at `pose`; infinity without points.
  /// It changes by no more than the farthest move of any point of the body.
  /// A value of `enough` [m] or less may be returned early: then it is the slack of some point, not the least.
  double slack(const Pose2& pose, const Footprint& footprint, double enough = -std::numeric_limits<double>::infinity());

  /// Number of points taken.
  std::size_t size() const { return count_; }

 private:
  std::size_t count_ = 0, last_hit_ = 0;
  std::vector<double> x_, y_, keep_;  // padded to whole vectors with points far away
};

}  // namespace lfdcore
