#include "lfdcore/control/footprint_rollout.hpp"

#include <limits>

#include "lfdcore/control/pure_pursuit.hpp"
#include "lfdcore/error.hpp"
#include "lfdcore/grid/swept_contact.hpp"

namespace lfdcore {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
/// As near as this the path's end counts as reached [m].
constexpr double end_tolerance = 0.05;
constexpr double longest_horizon = 600.0;  // [s]

struct Pursuit {
  const Path& path;
  const MotionLimits& limits;
  const FootprintRolloutConfig& config;

  // The end is reached when it is near, or lies behind the axle once it is what is pursued closely.
  bool ended(const PurePursuitResult& at) const {
    const double distance = at.control_point.norm();
    return at.at_end && (distance < end_tolerance || (at.control_point.x() <= 0 && distance < config.look_ahead / 2));
  }

  PurePursuitResult look(const Pose2& pose) const {
    const double remaining =
        Eigen::Vector2d(path(path.rows() - 1, 0) - pose.x, path(path.rows() - 1, 1) - pose.y).norm();
    const auto ahead = pure_pursuit(path, pose, config.look_ahead, config.linear, limits.max_angular);
    if (!ahead.at_end) return ahead;
    // v^2 = 2 b d: slow enough to brake within what is left, never so slow that it does not arrive.
    const double arriving = std::max(0.05, std::sqrt(limits.linear_braking * remaining));
    return pure_pursuit(path, pose, config.look_ahead, std::min(config.linear, arriving), limits.max_angular);
  }
};

void append(FootprintRollout& rollout, Eigen::Index step, const Pose2& pose, double clearance) {
  rollout.poses.row(step) << pose.x, pose.y, pose.yaw;
  rollout.min_clearance = std::min(rollout.min_clearance, clearance);
}

}  // namespace

void validate(const FootprintRolloutConfig& config) {
  require_positive("look_ahead", config.look_ahead, "m");
  require_positive("linear", config.linear, "m/s");
  require_positive("step", config.step, "s");
  require_between("duration", config.duration, config.step, std::min(longest_horizon, 10000 * config.step), "s");
}

FootprintRollout rollout_pursuit(const Path& path, const ObstaclePoints& obstacles, const Footprint& footprint,
                                 const MotionLimits& limits, const Twist2& twist,
                                 const FootprintRolloutConfig& config) {
  require_bounded(footprint);
  validate(limits);
  validate(config);
  require_finite("twist.linear", twist.linear, "m/s");
  require_finite("twist.angular", twist.angular, "rad/s");
  require(path.rows() >= 1 && path.allFinite(), "path needs at least one point, all finite [m]");
  const Pursuit pursuit{path, limits, config};
  const auto steps = static_cast<Eigen::Index>(std::floor(config.duration / config.step + 1e-9));
  FootprintRollout rollout{PosePath(steps + 1, 3), infinity, infinity, false};
  Pose2 pose;
  Twist2 speed = twist;
  append(rollout, 0, pose, obstacles.clearance(pose, footprint));
  Eigen::Index done = 0;
  for (; done < steps; ++done) {
    const PurePursuitResult ahead = pursuit.look(pose);
    rollout.reached_end = pursuit.ended(ahead);
    if (rollout.reached_end) break;
    speed = approach(speed, ahead.twist, limits, config.step);
    if (const auto contact = first_contact(obstacles, footprint, pose, speed, config.step)) {
      rollout.time_to_contact = static_cast<double>(done) * config.step + *contact;
      rollout.min_clearance = 0;
      break;
    }
    pose = integrate(pose, speed, config.step);
    append(rollout, done + 1, pose, obstacles.clearance(pose, footprint));
  }
  rollout.poses.conservativeResize(done + 1, 3);
  return rollout;
}

double time_to_contact(const Twist2& twist, const ObstaclePoints& obstacles, const Footprint& footprint,
                       double horizon) {
  require_bounded(footprint);
  require_between("twist.linear", twist.linear, -10, 10, "m/s");
  require_between("twist.angular", twist.angular, -10, 10, "rad/s");
  require_positive("horizon", horizon, "s");
  require_between("horizon", horizon, 0, longest_horizon, "s");
  return first_contact(obstacles, footprint, Pose2{}, twist, horizon).value_or(infinity);
}

}  // namespace lfdcore
