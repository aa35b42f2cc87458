#include "lfdcore/grid/obstacle_points.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

// Squared distance from a point in the body's frame to the rectangle; 0 inside.
double squared_distance(double x, double y, const Footprint& f) {
  const double dx = std::max({x - f.front, -f.rear - x, 0.0});
  const double dy = std::max(std::abs(y) - f.half_width, 0.0);
  return dx * dx + dy * dy;
}

}  // namespace

ObstaclePoints::ObstaclePoints(Path points) : points_(std::move(points)) {
  require(points_.allFinite(), "obstacle points must be finite [m]");
}

bool ObstaclePoints::collides(const Pose2& pose, const Footprint& footprint) const {
  return clearance(pose, footprint) <= 0;
}

double ObstaclePoints::clearance(const Pose2& pose, const Footprint& footprint) const {
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  double nearest = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < points_.rows(); ++i) {
    const double dx = points_(i, 0) - pose.x, dy = points_(i, 1) - pose.y;
    nearest = std::min(nearest, squared_distance(c * dx + s * dy, -s * dx + c * dy, footprint));
  }
  return std::sqrt(nearest);
}

}  // namespace lfdcore
