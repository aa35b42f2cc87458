// A robot read from a URDF: its joints, links, frames and collision capsules.
#pragma once

#include <memory>

#include "lfdcore/kinematics/kinematic_chain.hpp"

namespace lfdcore {

/// All points within `radius` [m] of the segment from a to b [m], in the frame of a link. A sphere has a = b.
struct Capsule {
  int link = 0;  ///< index into RobotModel::link_names()
  Eigen::Vector3d a, b;
  double radius = 0;
};

/// Immutable; copies share what was read. Joints and links come depth first from the root, siblings by the names of
/// their joints. A mimic joint is a joint of its own here, and refused in a chain.
class RobotModel {
 public:
  /// From a URDF's text. Throws DataError for what is no URDF of a tree of fixed, revolute, continuous and prismatic
  /// joints: malformed or truncated XML, XML with a document type or entities, above 16 MiB or 2000 links, links
  /// without names, links with two parents, loops, revolute or prismatic joints without limits, axes of length zero.
  static RobotModel from_urdf(const std::string& xml);

  /// The same from a file; also DataError where it cannot be read.
  static RobotModel from_urdf_file(const std::string& path);

  const std::string& name() const;
  const std::vector<std::string>& joint_names() const;  ///< movable joints, N
  const std::vector<std::string>& link_names() const;   ///< L, the root first
  const std::vector<JointLimits>& limits() const;       ///< N

  /// The chain from `base` to the tool that T_tip_tool places in the frame of `tip` (both names of links, `base` need
  /// not be above `tip`). Throws std::invalid_argument for unknown links, a chain without movable joints, and one with
  /// a joint that mimics another: solved as free, it would not be what the robot does.
  KinematicChain chain(const std::string& base, const std::string& tip,
                       const Eigen::Isometry3d& T_tip_tool = Eigen::Isometry3d::Identity()) const;

  /// T_root_link of every link at q (N,). Throws std::invalid_argument for another length or values not finite.
  std::vector<Eigen::Isometry3d> forward(const Eigen::VectorXd& q) const;

  /// What the links' collision shapes become: spheres as they are, cylinders and boxes the capsule along their longest
  /// axis that contains them. Meshes are not read.
  const std::vector<Capsule>& capsules() const;

  /// Of each link: the index of the joint that moves it against the root last, -1 if none does.
  const std::vector<int>& moved_by() const;

  /// Of each joint: the joint above it, -1 if none.
  const std::vector<int>& joint_above() const;

  /// Of each of these names the index among the joints. Throws std::invalid_argument for an unknown name.
  std::vector<int> joint_indices(const std::vector<std::string>& names) const;

  struct Description;  ///< what was read; opaque

 private:
  explicit RobotModel(std::shared_ptr<const Description> description) : description_(std::move(description)) {}
  std::shared_ptr<const Description> description_;
};

}  // namespace lfdcore
