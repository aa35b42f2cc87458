#include "lfdcore/control/pure_pursuit.hpp"

#include <algorithm>
#include <limits>
#include <string>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

// A point of a polyline: on the segment from vertex `segment`, at `share` of it.
struct OnPath {
  Eigen::Vector2d point;
  Eigen::Index segment = 0;
  double share = 0;
};

Eigen::Vector2d vertex(const Path& path, Eigen::Index i) { return path.row(i).transpose(); }

OnPath closest_point(const Path& path, const Eigen::Vector2d& to) {
  OnPath best{vertex(path, 0)};
  double nearest = (best.point - to).squaredNorm();
  for (Eigen::Index i = 0; i + 1 < path.rows(); ++i) {
    const Eigen::Vector2d a = vertex(path, i), along = vertex(path, i + 1) - a;
    const double length2 = along.squaredNorm();
    const double share = length2 > 0 ? std::clamp((to - a).dot(along) / length2, 0.0, 1.0) : 0.0;
    const Eigen::Vector2d point = a + share * along;
    const double distance2 = (point - to).squaredNorm();
    if (distance2 < nearest) {
      nearest = distance2;
      best = {point, i, share};
    }
  }
  return best;
}

// The end of the path, as a point on its last segment.
OnPath end_point(const Path& path) {
  const Eigen::Index last = path.rows() - 1;
  return {vertex(path, last), std::max<Eigen::Index>(last - 1, 0), last > 0 ? 1.0 : 0.0};
}

// Where the path first leaves the circle about `centre` from a point within it; the path's end if it never does.
OnPath leaving_point(const Path& path, const OnPath& from, const Eigen::Vector2d& centre, double radius) {
  for (Eigen::Index i = from.segment; i + 1 < path.rows(); ++i) {
    const Eigen::Vector2d b = vertex(path, i + 1);
    if ((b - centre).norm() < radius) continue;
    // |a + s (b - a) - centre| = radius, the larger root: the segment starts inside and ends outside.
    const Eigen::Vector2d a = vertex(path, i), along = b - a, offset = a - centre;
    const double length2 = along.squaredNorm(), half = offset.dot(along);
    const double discriminant = half * half - length2 * (offset.squaredNorm() - radius * radius);
    if (!(length2 > 0)) continue;
    const double share = std::clamp((-half + std::sqrt(std::max(discriminant, 0.0))) / length2, 0.0, 1.0);
    return {a + share * along, i, share};
  }
  return end_point(path);
}

double arc_length_at(const Path& path, const OnPath& at) {
  double length = 0;
  for (Eigen::Index i = 0; i < at.segment; ++i) length += (path.row(i + 1) - path.row(i)).norm();
  return length + (at.point - vertex(path, at.segment)).norm();
}

// Alg. 7: omega = v / r with r = |g|^2 / (2 g_y).
Twist2 twist_towards(const Eigen::Vector2d& g, double linear, double max_angular) {
  const double distance = g.norm();
  if (linear == 0 || distance < 1e-9) return {};
  if (g.x() < 0) return {0, g.y() < 0 ? -max_angular : max_angular};
  const double curvature = 2 * (g.y() / distance) / distance;
  const double speed = std::abs(curvature) * linear > max_angular ? max_angular / std::abs(curvature) : linear;
  return {speed, std::clamp(speed * curvature, -max_angular, max_angular)};
}

void check(const Path& path, const Pose2& pose, double look_ahead, double linear, double max_angular) {
  require(path.rows() >= 1, "the path has 0 points, must have at least 1");
  require(path.allFinite(), "path points must be finite [m]");
  require_finite("pose x", pose.x, "m");
  require_finite("pose y", pose.y, "m");
  require_finite("pose yaw", pose.yaw, "rad");
  require_positive("look_ahead", look_ahead, "m");
  require_finite("linear", linear, "m/s");
  require_between("linear", linear, 0, std::numeric_limits<double>::max(), "m/s");
  require_positive("max_angular", max_angular, "rad/s");
}

}  // namespace

PurePursuitResult pure_pursuit(const Path& path, const Pose2& pose, double look_ahead, double linear,
                               double max_angular) {
  check(path, pose, look_ahead, linear, max_angular);
  const Eigen::Vector2d robot(pose.x, pose.y);
  const OnPath closest = closest_point(path, robot);
  const bool off_path = (closest.point - robot).norm() > look_ahead;
  const OnPath control = off_path ? closest : leaving_point(path, closest, robot, look_ahead);

  PurePursuitResult result;
  result.control_point = pose.inverse() * control.point;
  result.twist = twist_towards(result.control_point, linear, max_angular);
  result.arc_length = arc_length_at(path, control);
  result.at_end = !off_path && control.point == vertex(path, path.rows() - 1);
  return result;
}

PurePursuitResult pure_pursuit(const Path& path, double look_ahead, double linear, double max_angular) {
  return pure_pursuit(path, Pose2{}, look_ahead, linear, max_angular);
}

}  // namespace lfdcore
