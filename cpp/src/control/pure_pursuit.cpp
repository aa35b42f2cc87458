#include "lfdcore/control/pure_pursuit.hpp"

#include <limits>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

struct OnPath {
  Eigen::Index segment = 0;
  double share = 0;  // of the segment, in [0, 1]
};

Eigen::Vector2d vertex(const Path& path, Eigen::Index i) { return path.row(i).transpose(); }

OnPath closest(const Path& path, const Eigen::Vector2d& position) {
  OnPath best;
  double nearest = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i + 1 < path.rows(); ++i) {
    const Eigen::Vector2d a = vertex(path, i), along = vertex(path, i + 1) - a;
    const double squared = along.squaredNorm();
    const double share = squared > 0 ? std::clamp((position - a).dot(along) / squared, 0.0, 1.0) : 0.0;
    const double distance = (a + share * along - position).squaredNorm();
    if (distance < nearest) nearest = distance, best = {i, share};
  }
  return best;
}

// Share of the segment at which it leaves the circle; negative if it does not.
double leaves_circle(const Eigen::Vector2d& from, const Eigen::Vector2d& along, double radius) {
  const double a = along.squaredNorm(), b = from.dot(along), c = from.squaredNorm() - radius * radius;
  const double discriminant = b * b - a * c;
  return a > 0 && discriminant >= 0 ? (-b + std::sqrt(discriminant)) / a : -1.0;
}

Twist2 towards(const Eigen::Vector2d& goal, double linear, double max_angular) {
  const double squared = goal.squaredNorm();
  if (squared == 0) return {};
  if (goal.x() < 0) return {0, std::copysign(max_angular, goal.y())};
  const double angular = 2 * linear * goal.y() / squared;  // Eq. E.1
  const double slower = std::min(1.0, max_angular / std::max(std::abs(angular), 1e-9));
  return {linear * slower, angular * slower};
}

}  // namespace

PurePursuitResult pure_pursuit(const Path& path, double look_ahead, double linear, double max_angular) {
  return pure_pursuit(path, Pose2{}, look_ahead, linear, max_angular);
}

PurePursuitResult pure_pursuit(const Path& path, const Pose2& pose, double look_ahead, double linear,
                               double max_angular) {
  require(path.rows() >= 1 && path.allFinite(), "a path to pursue needs at least one point, all finite [m]");
  const Eigen::Vector2d position(pose.x, pose.y);
  const OnPath start = closest(path, position);
  double length = 0;
  for (Eigen::Index i = 0; i + 1 < path.rows(); ++i) {
    const Eigen::Vector2d a = vertex(path, i), along = vertex(path, i + 1) - a;
    const double share = i < start.segment ? -1 : leaves_circle(a - position, along, look_ahead);
    if (share >= (i == start.segment ? start.share : 0.0) && share <= 1) {
      const Eigen::Vector2d goal = pose.inverse() * Eigen::Vector2d(a + share * along);
      return {goal, towards(goal, linear, max_angular), length + share * along.norm(), false};
    }
    length += along.norm();
  }
  const Eigen::Vector2d goal = pose.inverse() * vertex(path, path.rows() - 1);
  return {goal, towards(goal, linear, max_angular), length, true};
}

}  // namespace lfdcore
