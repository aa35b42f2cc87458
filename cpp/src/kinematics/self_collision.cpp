#include "lfdcore/kinematics/self_collision.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <set>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

/// Uniform inside the limits (a continuous joint: one turn), the same on every machine.
Eigen::VectorXd random_posture(const RobotModel& model, std::mt19937& generator) {
  Eigen::VectorXd q(model.limits().size());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const JointLimits& limits = model.limits()[static_cast<std::size_t>(i)];
    const double share = (static_cast<double>(generator()) + 0.5) / 4294967296.0;
    const bool continuous = std::isinf(limits.lower);
    q[i] = continuous ? std::numbers::pi * (2 * share - 1) : limits.lower + share * (limits.upper - limits.lower);
  }
  return q;
}

}  // namespace

// The closest points of two segments (Ericson, Real-Time Collision Detection, 5.1.9).
double capsule_distance(const Capsule& one, const Capsule& two) {
  const Eigen::Vector3d u = one.b - one.a, v = two.b - two.a, r = one.a - two.a;
  const double uu = u.squaredNorm(), vv = v.squaredNorm(), ur = u.dot(r), vr = v.dot(r), uv = u.dot(v);
  constexpr double point = 1e-12;  // [m^2] a segment shorter than this is a sphere
  double s = 0, t = 0;
  if (uu > point) {
    const double across = uu * vv - uv * uv;
    if (vv > point && across > 1e-12 * uu * vv) s = std::clamp((uv * vr - ur * vv) / across, 0.0, 1.0);
    if (vv <= point) s = std::clamp(-ur / uu, 0.0, 1.0);
  }
  if (vv > point) {
    t = (uv * s + vr) / vv;
    if (t < 0 || t > 1) {
      t = std::clamp(t, 0.0, 1.0);
      if (uu > point) s = std::clamp((uv * t - ur) / uu, 0.0, 1.0);
    }
  }
  return (r + s * u - t * v).norm() - one.radius - two.radius;
}

SelfCollision::SelfCollision(RobotModel model, const std::vector<Names>& ignored) : model_(std::move(model)) {
  require(!model_.capsules().empty(), "the robot has no collision shapes (meshes are not read)");
  std::set<Names> left_out;
  const auto& links = model_.link_names();
  for (const auto& [a, b] : ignored) {
    for (const std::string& name : {a, b})
      require(std::find(links.begin(), links.end(), name) != links.end(), "the robot has no link '" + name + "'");
    left_out.insert({a, b});
    left_out.insert({b, a});
  }
  const auto& capsules = model_.capsules();
  for (std::size_t i = 0; i < capsules.size(); ++i) {
    for (std::size_t j = i + 1; j < capsules.size(); ++j) {
      const Names names{links[static_cast<std::size_t>(capsules[i].link)],
                        links[static_cast<std::size_t>(capsules[j].link)]};
      if (can_meet(capsules[i], capsules[j]) && !left_out.contains(names)) compared_.push_back({i, j});
    }
  }
  drop_always_touching();
  list_pairs();
}

bool SelfCollision::can_meet(const Capsule& a, const Capsule& b) const {
  const auto joints_to_root = [this](int link) {
    std::vector<int> joints;
    for (int joint = model_.moved_by()[static_cast<std::size_t>(link)]; joint >= 0;
         joint = model_.joint_above()[static_cast<std::size_t>(joint)])
      joints.push_back(joint);
    return joints;
  };
  const auto first = joints_to_root(a.link), second = joints_to_root(b.link);
  const auto [i, j] = std::mismatch(first.rbegin(), first.rend(), second.rbegin(), second.rend());
  return (first.rend() - i) + (second.rend() - j) > 2;
}

std::vector<Capsule> SelfCollision::placed(const Eigen::VectorXd& q) const {
  const auto poses = model_.forward(q);
  std::vector<Capsule> capsules = model_.capsules();
  for (Capsule& capsule : capsules) {
    const Eigen::Isometry3d& T = poses[static_cast<std::size_t>(capsule.link)];
    capsule.a = T * capsule.a;
    capsule.b = T * capsule.b;
  }
  return capsules;
}

void SelfCollision::drop_always_touching() {
  std::mt19937 generator(1);
  std::vector<bool> came_free(compared_.size(), false);
  for (int i = 0; i < 200; ++i) {
    const auto capsules = placed(random_posture(model_, generator));
    for (std::size_t k = 0; k < compared_.size(); ++k)
      if (capsule_distance(capsules[compared_[k].first], capsules[compared_[k].second]) > 0) came_free[k] = true;
  }
  std::vector<Compared> kept;
  for (std::size_t k = 0; k < compared_.size(); ++k)
    if (came_free[k]) kept.push_back(compared_[k]);
  compared_ = std::move(kept);
}

void SelfCollision::list_pairs() {
  std::set<std::pair<int, int>> links;
  for (const Compared& pair : compared_)
    links.insert({model_.capsules()[pair.first].link, model_.capsules()[pair.second].link});
  pairs_.assign(links.begin(), links.end());
}

SelfDistance SelfCollision::distance(const Eigen::VectorXd& q) const {
  const auto capsules = placed(q);
  SelfDistance nearest{.distance = std::numeric_limits<double>::infinity()};
  for (const Compared& pair : compared_) {
    const Capsule &a = capsules[pair.first], &b = capsules[pair.second];
    const double distance = capsule_distance(a, b);
    if (distance < nearest.distance) nearest = {distance, a.link, b.link};
  }
  return nearest;
}

}  // namespace lfdcore
