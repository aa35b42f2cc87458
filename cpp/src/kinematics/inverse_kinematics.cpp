#include "lfdcore/kinematics/inverse_kinematics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "../vectorised.hpp"
#include "bounded_step.hpp"
#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

/// Metres that a radian counts for when postures are ranked: about the arm's lever.
constexpr float ranking_lever = 0.3F;

double halton(int index, int base) {
  double value = 0, digit = 1;
  for (; index > 0; index /= base) {
    digit /= base;
    value += digit * (index % base);
  }
  return value;
}

/// The first primes, one base for each joint.
std::array<int, max_chain_joints> primes() {
  std::array<int, max_chain_joints> found{};
  std::size_t count = 0;
  for (int n = 2; count < found.size(); ++n) {
    if (std::none_of(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(count),
                     [n](int p) { return n % p == 0; }))
      found[count++] = n;
  }
  return found;
}

/// Where a joint's postures lie; a continuous joint's within one turn.
double between(const KinematicChain& chain, int joint, double share) {
  const bool continuous = std::isinf(chain.lower()[joint]);
  const double low = continuous ? -std::numbers::pi : chain.lower()[joint];
  const double high = continuous ? std::numbers::pi : chain.upper()[joint];
  return low + share * (high - low);
}

Eigen::Matrix<float, 12, 1> feature(const Eigen::Isometry3d& T) {
  Eigen::Matrix<float, 12, 1> made;
  made.head<3>() = T.translation().cast<float>();
  for (int column = 0; column < 3; ++column)
    made.segment<3>(3 + 3 * column) = ranking_lever * T.linear().col(column).cast<float>();
  return made;
}

LFDCORE_CLONES void squared_distances(const float* features, const float* wanted, int count, float* distances) {
  for (int i = 0; i < count; ++i) distances[i] = 0;
  for (int k = 0; k < 12; ++k) {
    const float* column = features + static_cast<std::ptrdiff_t>(k) * count;
    for (int i = 0; i < count; ++i) {
      const float difference = column[i] - wanted[k];
      distances[i] += difference * difference;
    }
  }
}

}  // namespace

void validate(const InverseKinematicsConfig& config) {
  require_positive("position_tolerance", config.position_tolerance, "m");
  require_positive("rotation_tolerance", config.rotation_tolerance, "rad");
  require_between("iterations", config.iterations, 1, 10000, "");
  require_between("restarts", config.restarts, 0, 100000, "");
  require_between("postures", config.postures, 1, 1 << 20, "");
  require_positive("damping", config.damping, "");
}

/// The fixed postures, nearest tool first, one at a time.
class InverseKinematics::Ranking {
 public:
  Ranking(const InverseKinematics& solver, const Eigen::Isometry3d& wanted)
      : distances_(static_cast<std::size_t>(solver.features_.rows())) {
    const Eigen::Matrix<float, 12, 1> target = feature(wanted);
    squared_distances(solver.features_.data(), target.data(), static_cast<int>(distances_.size()), distances_.data());
  }

  int next() {
    const auto best = std::min_element(distances_.begin(), distances_.end());
    *best = std::numeric_limits<float>::infinity();
    return static_cast<int>(best - distances_.begin());
  }

 private:
  std::vector<float> distances_;
};

InverseKinematics::InverseKinematics(KinematicChain chain, const InverseKinematicsConfig& config)
    : chain_(std::move(chain)), config_(config) {
  validate(config_);
  const auto bases = primes();
  postures_.resize(config_.postures, chain_.size());
  features_.resize(config_.postures, 12);
  ChainJacobian unused;
  for (int i = 0; i < config_.postures; ++i) {
    for (int j = 0; j < chain_.size(); ++j) {
      const double share = i == 0 ? 0.5 : halton(i, bases[static_cast<std::size_t>(j)]);
      postures_(i, j) = static_cast<float>(between(chain_, j, share));
    }
    features_.row(i) = feature(chain_.evaluate(posture(i), unused)).transpose();
  }
}

JointVector InverseKinematics::posture(int index) const {
  return postures_.row(index).transpose().cast<double>().cwiseMax(chain_.lower()).cwiseMin(chain_.upper());
}

std::vector<JointVector> InverseKinematics::postures_near(const Eigen::Isometry3d& wanted, int count) const {
  Ranking ranking(*this, wanted);
  std::vector<JointVector> found;
  for (int i = 0; i < std::min(count, config_.postures); ++i) found.push_back(posture(ranking.next()));
  return found;
}

InverseKinematicsResult InverseKinematics::descend(const Eigen::Isometry3d& wanted, const JointVector& from) const {
  InverseKinematicsResult best;
  JointVector q = from;
  ChainJacobian J;
  double least = std::numeric_limits<double>::infinity();
  int idle = 0;
  for (int i = 0; i < config_.iterations && idle < 5; ++i) {
    const Vector6 error = pose_error(wanted, chain_.evaluate(q, J));
    const double squared = error.squaredNorm();
    idle = squared < 0.97 * least ? 0 : idle + 1;
    ++best.iterations;
    if (squared < least) {
      least = squared;
      best.joints = q;
      best.position_error = error.head<3>().norm();
      best.rotation_error = error.tail<3>().norm();
    }
    best.solved =
        best.position_error <= config_.position_tolerance && best.rotation_error <= config_.rotation_tolerance;
    if (best.solved) break;
    q += bounded_step(J, error, config_.damping * squared + 1e-9, q, chain_.lower(), chain_.upper());
    q = q.cwiseMax(chain_.lower()).cwiseMin(chain_.upper());
  }
  return best;
}

InverseKinematicsResult InverseKinematics::solve(const Eigen::Isometry3d& wanted,
                                                 const std::optional<Eigen::VectorXd>& seed) const {
  require(wanted.matrix().allFinite(), "T_base_tool is not finite");
  InverseKinematicsResult best;
  best.position_error = best.rotation_error = std::numeric_limits<double>::infinity();
  int iterations = 0, descents = 0;
  const auto attempt = [&](const JointVector& from) {
    InverseKinematicsResult found = descend(wanted, from);
    iterations += found.iterations;
    ++descents;
    const bool nearer = found.position_error + found.rotation_error < best.position_error + best.rotation_error;
    if (found.solved || nearer) best = std::move(found);
  };
  if (seed) {
    chain_.require_joints(*seed, "seed");
    attempt(seed->cwiseMax(chain_.lower()).cwiseMin(chain_.upper()));
  }
  if (!best.solved && (config_.restarts > 0 || !seed)) {
    Ranking ranking(*this, wanted);
    const bool beyond = (wanted.translation() - chain_.root()).norm() > chain_.reach() + config_.position_tolerance;
    const int allowed = beyond ? 1 : std::min(std::max(config_.restarts, 1), config_.postures);
    for (int i = 0; i < allowed && !best.solved; ++i) attempt(posture(ranking.next()));
  }
  best.iterations = iterations;
  best.restarts = descents - 1;
  return best;
}

InverseKinematicsResult solve_inverse_kinematics(const KinematicChain& chain, const Eigen::Isometry3d& T_base_tool,
                                                 const InverseKinematicsConfig& config,
                                                 const std::optional<Eigen::VectorXd>& seed) {
  return InverseKinematics(chain, config).solve(T_base_tool, seed);
}

}  // namespace lfdcore
