#include "lfdcore/kinematics/joint_trajectory.hpp"

#include <algorithm>
#include <cmath>

#include "bounded_step.hpp"
#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

void require_times(const Eigen::VectorXd& time, Eigen::Index rows) {
  require(time.size() >= 2, "a trajectory needs at least 2 samples, got " + std::to_string(time.size()));
  require(time.size() == rows, "time has " + std::to_string(time.size()) + " values for " + std::to_string(rows) +
                                   " samples, must have one for each");
  require(time.allFinite(), "a value of time is not finite");
  for (Eigen::Index i = 1; i < time.size(); ++i)
    require(time[i] > time[i - 1], "time must increase, but does not at index " + std::to_string(i));
}

Eigen::VectorXd intervals(const Eigen::VectorXd& time) {
  return time.tail(time.size() - 1) - time.head(time.size() - 1);
}

/// Each value becomes the mean over +-reach of the maximum over +-reach: smooth, and nowhere less than it was.
Eigen::VectorXd raised_smoothly(const Eigen::VectorXd& values, Eigen::Index reach) {
  Eigen::VectorXd highest(values.size()), smooth(values.size());
  const auto window = [&](Eigen::Index i) {
    const Eigen::Index from = std::max<Eigen::Index>(0, i - reach);
    return std::pair{from, std::min(values.size() - 1, i + reach) - from + 1};
  };
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const auto [from, count] = window(i);
    highest[i] = values.segment(from, count).maxCoeff();
  }
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const auto [from, count] = window(i);
    smooth[i] = std::max(values[i], highest.segment(from, count).mean());
  }
  return smooth;
}

/// One way of following the poses, from one first posture.
class Follower {
 public:
  Follower(const InverseKinematics& solver, const Eigen::VectorXd& time, const std::vector<Eigen::Isometry3d>& poses,
           const FollowConfig& config, const std::optional<Surroundings>& surroundings)
      : solver_(solver), time_(time), poses_(poses), config_(config), surroundings_(surroundings) {
    const KinematicChain& chain = solver.chain();
    middle_ = 0.5 * (chain.lower() + chain.upper());
    for (Eigen::Index i = 0; i < middle_.size(); ++i)
      if (!std::isfinite(middle_[i])) middle_[i] = 0;
    if (surroundings) indices_ = surroundings->robot.model().joint_indices(chain.joint_names());
  }

  SelfDistance nearest(const JointVector& q, std::size_t sample) const {
    if (!surroundings_) return {.distance = std::numeric_limits<double>::infinity()};
    const RowMatrix& posture = surroundings_->posture;
    Eigen::VectorXd all = posture.row(posture.rows() == 1 ? 0 : static_cast<Eigen::Index>(sample)).transpose();
    for (std::size_t i = 0; i < indices_.size(); ++i) all[indices_[i]] = q[static_cast<Eigen::Index>(i)];
    return surroundings_->robot.distance(all);
  }

  FollowResult follow(const InverseKinematicsResult& first) const {
    FollowResult result;
    result.clearance = std::numeric_limits<double>::infinity();
    RowMatrix& positions = result.trajectory.positions;
    positions.resize(static_cast<Eigen::Index>(poses_.size()), solver_.chain().size());
    JointVector q = first.joints;
    std::size_t done = 0;
    for (; done < poses_.size(); ++done) {
      if (!advance(done, q, result)) break;
      positions.row(static_cast<Eigen::Index>(done)) = q.transpose();
    }
    finish(static_cast<Eigen::Index>(done), result);
    return result;
  }

  /// Less is better: slow, close to itself and close to the joints' limits are bad.
  double cost(const FollowResult& result) const {
    const KinematicChain& chain = solver_.chain();
    const RowMatrix& q = result.trajectory.positions;
    double room = 1;  // share of half a joint's range to its nearer limit
    for (Eigen::Index j = 0; j < q.cols(); ++j) {
      const double half = 0.5 * (chain.upper()[j] - chain.lower()[j]);
      if (std::isfinite(half)) room = std::min(room, 1 - (q.col(j).array() - middle_[j]).abs().maxCoeff() / half);
    }
    const double near = 1 - std::clamp(result.clearance / config_.avoidance, 0.0, 1.0);
    return result.slowdown + near - room;
  }

 private:
  bool advance(std::size_t sample, JointVector& q, FollowResult& result) const {
    const JointVector last = q;
    const double duration =
        sample == 0 ? 0 : time_[static_cast<Eigen::Index>(sample)] - time_[static_cast<Eigen::Index>(sample) - 1];
    const auto found = solver_.descend(poses_[sample], sample == 0 ? q : moved(sample, q, duration));
    q = found.joints;
    if (!found.solved || (q - last).cwiseAbs().maxCoeff() > config_.largest_step)
      return fail(sample, result, reachable(sample) ? FollowOutcome::no_continuous_path : FollowOutcome::out_of_reach);
    const SelfDistance near = nearest(q, sample);
    if (near.distance < result.clearance || sample == 0) result.nearest = near;
    result.clearance = std::min(result.clearance, near.distance);
    if (near.distance < config_.clearance) return fail(sample, result, FollowOutcome::self_collision);
    result.position_error = std::max(result.position_error, found.position_error);
    result.rotation_error = std::max(result.rotation_error, found.rotation_error);
    return true;
  }

  static bool fail(std::size_t sample, FollowResult& result, FollowOutcome outcome) {
    result.outcome = outcome;
    result.first_failure = static_cast<int>(sample);
    return false;
  }

  bool reachable(std::size_t sample) const { return solver_.solve(poses_[sample]).solved; }

  /// The first step to the next pose, with the free joints' own motion in it.
  JointVector moved(std::size_t sample, const JointVector& q, double duration) const {
    const KinematicChain& chain = solver_.chain();
    ChainJacobian J;
    const Vector6 error = pose_error(poses_[sample], chain.evaluate(q, J));
    JointVector own = duration * (config_.centring * (middle_ - q) + away(sample, q));
    own = (q + own).cwiseMax(chain.lower()).cwiseMin(chain.upper()) - q;
    const Vector6 left = error - J * own;
    const JointVector next = q + own;
    const JointVector step = bounded_step(J, left, 1e-6, next, chain.lower(), chain.upper());
    return (next + step).cwiseMax(chain.lower()).cwiseMin(chain.upper());
  }

  /// Joint velocities that part the nearest links, faster the nearer they are [rad/s].
  JointVector away(std::size_t sample, const JointVector& q) const {
    JointVector slope = JointVector::Zero(q.size());
    const double here = nearest(q, sample).distance;
    if (!(here < config_.avoidance)) return slope;
    constexpr double little = 1e-4;  // [rad]
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      JointVector shifted = q;
      shifted[i] += little;
      slope[i] = (nearest(shifted, sample).distance - here) / little;
    }
    const double length = slope.norm();
    if (length < 1e-9) return slope;
    return config_.avoidance_speed * std::min(1.0, 1 - here / config_.avoidance) / length * slope;
  }

  void finish(Eigen::Index done, FollowResult& result) const {
    JointTrajectory& trajectory = result.trajectory;
    trajectory.positions.conservativeResize(done, Eigen::NoChange);
    trajectory.time = time_.head(done);
    trajectory.velocities = RowMatrix::Zero(done, solver_.chain().size());
    if (done < 2) return;
    const Eigen::VectorXd allowed = config_.velocity_share * solver_.chain().velocity();
    trajectory.time = slow_down(trajectory.time, trajectory.positions, allowed, config_.smoothing);
    trajectory.velocities = joint_velocities(trajectory.time, trajectory.positions);
    result.slowdown = (trajectory.time[done - 1] - trajectory.time[0]) / (time_[done - 1] - time_[0]);
  }

  const InverseKinematics& solver_;
  const Eigen::VectorXd& time_;
  const std::vector<Eigen::Isometry3d>& poses_;
  const FollowConfig& config_;
  const std::optional<Surroundings>& surroundings_;
  JointVector middle_;
  std::vector<int> indices_;
};

/// Different postures at the first pose, at most config.starts; those free of self-collision if there are any.
std::vector<InverseKinematicsResult> first_postures(const InverseKinematics& solver, const Eigen::Isometry3d& pose,
                                                    const Follower& follower, const FollowConfig& config) {
  std::vector<InverseKinematicsResult> found;
  std::vector<InverseKinematicsResult> touching;
  for (const JointVector& near : solver.postures_near(pose, 16 * config.starts)) {
    if (static_cast<int>(found.size()) == config.starts) break;
    auto result = solver.descend(pose, near);
    const auto alike = [&](const auto& other) { return (other.joints - result.joints).norm() < 0.3; };
    if (!result.solved || std::any_of(found.begin(), found.end(), alike)) continue;
    const bool free = follower.nearest(result.joints, 0).distance >= config.clearance;
    (free ? found : touching).push_back(std::move(result));
  }
  if (found.empty() && !touching.empty()) found.push_back(touching.front());
  if (found.empty()) found.push_back(solver.solve(pose));
  return found;
}

void check(const KinematicChain& chain, const Eigen::VectorXd& time, const std::vector<Eigen::Isometry3d>& poses,
           const FollowConfig& config, const std::optional<Surroundings>& surroundings) {
  validate(config);
  require_times(time, static_cast<Eigen::Index>(poses.size()));
  for (int i = 0; i < chain.size(); ++i)
    if (!(chain.velocity()[i] > 0))
      throw std::invalid_argument("joint '" + chain.joint_names()[static_cast<std::size_t>(i)] +
                                  "' has a velocity limit of 0 in the robot's description: it could never move");
  for (const auto& pose : poses) require(pose.matrix().allFinite(), "a value of T_base_tool is not finite");
  if (!surroundings) return;
  const RowMatrix& posture = surroundings->posture;
  const auto joints = static_cast<Eigen::Index>(surroundings->robot.model().joint_names().size());
  const bool rows = posture.rows() == 1 || posture.rows() == time.size();
  require(rows && posture.cols() == joints && posture.allFinite(),
          "posture must be finite, with one row or one for each of the " + std::to_string(time.size()) +
              " poses, and one column for each of the robot's " + std::to_string(joints) + " joints");
}

}  // namespace

void validate(const FollowConfig& config) {
  validate(config.inverse_kinematics);
  require_between("centring", config.centring, 0, 100, "1/s");
  require_between("clearance", config.clearance, 0, 10, "m");
  require_positive("avoidance", config.avoidance, "m");
  require_between("avoidance_speed", config.avoidance_speed, 0, 100, "rad/s");
  require_positive("largest_step", config.largest_step, "rad");
  require_between("velocity_share", config.velocity_share, 1e-3, 1, "");
  require_between("smoothing", config.smoothing, 0, 1e3, "s");
  require_between("starts", config.starts, 1, 1000, "");
}

const char* to_string(FollowOutcome outcome) {
  switch (outcome) {
    case FollowOutcome::followed:
      return "followed";
    case FollowOutcome::out_of_reach:
      return "out_of_reach";
    case FollowOutcome::no_continuous_path:
      return "no_continuous_path";
    default:
      return "self_collision";
  }
}

FollowResult follow_poses(const KinematicChain& chain, const Eigen::VectorXd& time,
                          const std::vector<Eigen::Isometry3d>& T_base_tool,
                          const std::optional<Eigen::VectorXd>& start, const FollowConfig& config,
                          const std::optional<Surroundings>& surroundings) {
  check(chain, time, T_base_tool, config, surroundings);
  const InverseKinematics solver(chain, config.inverse_kinematics);
  const Follower follower(solver, time, T_base_tool, config, surroundings);
  if (start) return follower.follow(solver.solve(T_base_tool.front(), start));
  std::optional<FollowResult> best;
  const auto better = [&](const FollowResult& made) {
    if (!best) return true;
    const auto here = made.trajectory.time.size(), there = best->trajectory.time.size();
    return here != there ? here > there : follower.cost(made) < follower.cost(*best);
  };
  for (const auto& first : first_postures(solver, T_base_tool.front(), follower, config)) {
    FollowResult made = follower.follow(first);
    if (better(made)) best = std::move(made);
  }
  return *best;
}

Eigen::VectorXd slow_down(const Eigen::VectorXd& time, const RowMatrix& positions, const Eigen::VectorXd& velocity,
                          double smoothing) {
  require_times(time, positions.rows());
  require(positions.allFinite(), "a value of positions is not finite");
  require(
      velocity.size() == positions.cols() && (velocity.array() > 0).all(),
      "velocity must be above 0 and have one value for each of the " + std::to_string(positions.cols()) + " joints");
  require_between("smoothing", smoothing, 0, 1e3, "s");
  Eigen::VectorXd taken = intervals(time);
  Eigen::VectorXd stretch(taken.size());
  for (Eigen::Index i = 0; i < taken.size(); ++i) {
    const auto moved = (positions.row(i + 1) - positions.row(i)).cwiseAbs();
    stretch[i] = std::max(1.0, (moved.transpose().array() / velocity.array()).maxCoeff() / taken[i]);
  }
  const double mean = taken.mean();
  const auto reach = static_cast<Eigen::Index>(std::min(smoothing / mean, static_cast<double>(taken.size())));
  taken.array() *= raised_smoothly(stretch, reach).array();
  Eigen::VectorXd slowed(time.size());
  slowed[0] = time[0];
  for (Eigen::Index i = 0; i < taken.size(); ++i) slowed[i + 1] = slowed[i] + taken[i];
  return slowed;
}

RowMatrix joint_velocities(const Eigen::VectorXd& time, const RowMatrix& positions) {
  require_times(time, positions.rows());
  require(positions.allFinite(), "a value of positions is not finite");
  const Eigen::VectorXd taken = intervals(time);
  const Eigen::Index last = positions.rows() - 1;
  const auto chord = [&](Eigen::Index i) { return (positions.row(i + 1) - positions.row(i)) / taken[i]; };
  RowMatrix found(positions.rows(), positions.cols());
  found.row(0) = chord(0);
  found.row(last) = chord(last - 1);
  for (Eigen::Index i = 1; i < last; ++i)
    found.row(i) = (taken[i] * chord(i - 1) + taken[i - 1] * chord(i)) / (taken[i - 1] + taken[i]);
  return found;
}

}  // namespace lfdcore
