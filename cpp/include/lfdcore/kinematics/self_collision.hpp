// How far a robot's links are from each other.
#pragma once

#include <utility>

#include "lfdcore/kinematics/robot_model.hpp"

namespace lfdcore {

/// The two links that come nearest to each other, by index into RobotModel::link_names().
struct SelfDistance {
  double distance = 0;  ///< [m], below 0 by how deep they overlap; inf where nothing is compared
  int first = -1;
  int second = -1;
};

/// Distance of the points nearest to each other on two capsules [m], below 0 where they overlap.
double capsule_distance(const Capsule& a, const Capsule& b);

/// Compares the capsules of all pairs of links except: links that at most two joints move against each other (their
/// joints' limits must keep them apart), pairs that overlap in every one of 200 fixed random postures (shapes that meet
/// by design), and pairs that the caller names.
class SelfCollision {
 public:
  using Names = std::pair<std::string, std::string>;

  /// Throws std::invalid_argument for names of links that are not there or a robot without collision shapes.
  explicit SelfCollision(RobotModel model, const std::vector<Names>& ignored = {});

  const RobotModel& model() const { return model_; }
  const std::vector<std::pair<int, int>>& pairs() const { return pairs_; }  ///< of links that are compared

  /// At q (N,) of all of the robot's joints. Throws like RobotModel::forward.
  SelfDistance distance(const Eigen::VectorXd& q) const;

 private:
  struct Compared {
    std::size_t first, second;  ///< capsules
  };
  bool can_meet(const Capsule& a, const Capsule& b) const;
  std::vector<Capsule> placed(const Eigen::VectorXd& q) const;
  void drop_always_touching();
  void list_pairs();

  RobotModel model_;
  std::vector<Compared> compared_;
  std::vector<std::pair<int, int>> pairs_;
};

}  // namespace lfdcore
