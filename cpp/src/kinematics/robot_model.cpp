#include "lfdcore/kinematics/robot_model.hpp"

#include <console_bridge/console.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <kdl/tree.hpp>
#include <limits>
#include <map>
#include <mutex>
#include <numbers>
#include <set>
#include <sstream>

#include "lfdcore/error.hpp"
#include "urdf_text.hpp"

namespace lfdcore {

struct RobotModel::Description {
  struct Link {
    int parent = -1;
    int joint = -1;  ///< index among the movable joints, -1 if fixed
    bool prismatic = false;
    Eigen::Vector3d axis;
    Eigen::Isometry3d T_parent_joint;
  };
  std::string name;
  KDL::Tree tree;
  std::vector<std::string> joint_names, link_names;
  std::vector<JointLimits> limits;
  std::map<std::string, std::string> mimics;  ///< a joint that follows another, and which
  std::vector<Link> links;
  std::vector<Capsule> capsules;
  std::vector<int> moved_by, joint_above;
};

namespace {

using Description = RobotModel::Description;

/// Keeps what urdfdom would print, for our own message. The library's output handler is global, hence the mutex.
class CapturedLog : public console_bridge::OutputHandler {
 public:
  CapturedLog() : lock_(mutex()) { console_bridge::useOutputHandler(this); }
  ~CapturedLog() override { console_bridge::restorePreviousOutputHandler(); }
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR) text_ += (text_.empty() ? "" : "; ") + text;
  }
  const std::string& text() const { return text_; }

 private:
  static std::mutex& mutex() {
    static std::mutex one;
    return one;
  }
  std::lock_guard<std::mutex> lock_;
  std::string text_;
};

urdf::ModelInterfaceSharedPtr parse(const std::string& xml) {
  CapturedLog log;
  urdf::ModelInterfaceSharedPtr model;
  std::string why;
  try {
    model = urdf::parseURDF(xml);
  } catch (const std::exception& error) {
    why = error.what();
  }
  if (!log.text().empty()) why = log.text();
  if (!model || !model->getRoot()) throw DataError("the URDF cannot be used: " + (why.empty() ? "no robot" : why));
  return model;
}

Eigen::Isometry3d isometry(const urdf::Pose& pose, const std::string& owner) {
  double x, y, z, w;
  pose.rotation.getQuaternion(x, y, z, w);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(w, x, y, z).normalized().toRotationMatrix();
  T.translation() << pose.position.x, pose.position.y, pose.position.z;
  if (!T.matrix().allFinite()) throw DataError("the URDF's origin of '" + owner + "' is not finite");
  return T;
}

Eigen::Vector3d unit_axis(const urdf::Joint& joint) {
  const Eigen::Vector3d axis(joint.axis.x, joint.axis.y, joint.axis.z);
  if (!(axis.norm() > 1e-9) || !axis.allFinite())
    throw DataError("the URDF's joint '" + joint.name + "' has an axis without direction");
  return axis.normalized();
}

JointLimits joint_limits(const urdf::Joint& joint) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  if (joint.type == urdf::Joint::CONTINUOUS) return {-inf, inf, joint.limits ? joint.limits->velocity : inf};
  if (!joint.limits) throw DataError("the URDF's joint '" + joint.name + "' has no limits");
  const JointLimits limits{joint.limits->lower, joint.limits->upper, joint.limits->velocity};
  if (!(limits.lower <= limits.upper) || !(limits.velocity >= 0) || std::isinf(limits.upper - limits.lower))
    throw DataError("the URDF's joint '" + joint.name + "' has limits that are no range or a velocity below 0");
  return limits;
}

bool movable(const urdf::Joint& joint) {
  switch (joint.type) {
    case urdf::Joint::REVOLUTE:
    case urdf::Joint::CONTINUOUS:
    case urdf::Joint::PRISMATIC:
      return true;
    case urdf::Joint::FIXED:
      return false;
    default:
      throw DataError("the URDF's joint '" + joint.name +
                      "' is floating, planar or of unknown type; fixed, revolute, continuous and prismatic are read");
  }
}

/// urdfdom itself takes links with two parents, and loops that hang on nothing.
void require_tree(const urdf::ModelInterface& model) {
  std::set<std::string> children;
  for (const auto& [name, joint] : model.joints_) {
    if (joint->child_link_name == joint->parent_link_name)
      throw DataError("the URDF's joint '" + name + "' joins link '" + joint->child_link_name + "' to itself");
    if (!children.insert(joint->child_link_name).second)
      throw DataError("the URDF's link '" + joint->child_link_name + "' has two parents: loops are refused");
  }
}

KDL::Frame frame(const Eigen::Isometry3d& T) {
  const Eigen::Matrix3d R = T.linear();
  return {KDL::Rotation(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)),
          KDL::Vector(T.translation().x(), T.translation().y(), T.translation().z())};
}

Eigen::Isometry3d isometry(const KDL::Frame& frame) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) T(row, column) = frame.M(row, column);
    T(row, 3) = frame.p(row);
  }
  return T;
}

KDL::Vector vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

KDL::Joint kdl_joint(const urdf::Joint& joint, const Eigen::Isometry3d& T_parent_joint) {
  if (!movable(joint)) return KDL::Joint(joint.name, KDL::Joint::Fixed);
  const KDL::Vector origin = vector(T_parent_joint.translation());
  const KDL::Vector axis = vector(T_parent_joint.linear() * unit_axis(joint));
  const bool slides = joint.type == urdf::Joint::PRISMATIC;
  return {joint.name, origin, axis, slides ? KDL::Joint::TransAxis : KDL::Joint::RotAxis};
}

/// The smallest capsule along the longest axis that contains a shape of half lengths h [m] (a cylinder: h = r, r, l/2).
Capsule containing(const Eigen::Isometry3d& T, const Eigen::Vector3d& half, double radius, int axis) {
  const Eigen::Vector3d along = T.linear().col(axis) * half[axis];
  return {0, T.translation() - along, T.translation() + along, radius};
}

std::vector<Capsule> capsule_of(const urdf::Collision& collision, const std::string& link) {
  if (!collision.geometry) return {};
  const Eigen::Isometry3d T = isometry(collision.origin, link);
  switch (collision.geometry->type) {
    case urdf::Geometry::SPHERE: {
      const auto& sphere = static_cast<const urdf::Sphere&>(*collision.geometry);
      return {{0, T.translation(), T.translation(), sphere.radius}};
    }
    case urdf::Geometry::CYLINDER: {
      const auto& cylinder = static_cast<const urdf::Cylinder&>(*collision.geometry);
      return {containing(T, {0, 0, cylinder.length / 2}, cylinder.radius, 2)};
    }
    case urdf::Geometry::BOX: {
      const auto& dim = static_cast<const urdf::Box&>(*collision.geometry).dim;
      const Eigen::Vector3d half(dim.x / 2, dim.y / 2, dim.z / 2);
      Eigen::Index longest;
      half.maxCoeff(&longest);
      const double radius = std::hypot(half[(longest + 1) % 3], half[(longest + 2) % 3]);
      return {containing(T, half, radius, static_cast<int>(longest))};
    }
    default:
      return {};
  }
}

/// A rotation that brings the z axis to `axis`, orthonormal to rounding for any.
Eigen::Matrix3d turn_z_to(const Eigen::Vector3d& axis) {
  if (axis.z() > -0.5) return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis).toRotationMatrix();
  Eigen::Matrix3d R;  // nearly opposite vectors do not tell which way to turn
  R.col(2) = axis;
  R.col(0) = axis.unitOrthogonal();
  R.col(1) = axis.cross(R.col(0));
  return R;
}

/// A chain's joints, each turned so that it moves about its own z axis, from KDL's segments.
class ChainBuilder {
 public:
  void add(const KDL::Segment& segment, const std::map<std::string, JointLimits>& limits) {
    const KDL::Joint& joint = segment.getJoint();
    const Eigen::Isometry3d to_tip = isometry(segment.pose(0.0));
    if (joint.getType() == KDL::Joint::Fixed) {
      T_ = T_ * to_tip;
      return;
    }
    const KDL::Vector a = joint.JointAxis(), o = joint.JointOrigin();
    Eigen::Isometry3d T_segment_joint = Eigen::Isometry3d::Identity();
    T_segment_joint.linear() = turn_z_to(Eigen::Vector3d(a.x(), a.y(), a.z()).normalized());
    T_segment_joint.translation() << o.x(), o.y(), o.z();
    const bool prismatic = joint.getType() == KDL::Joint::TransAxis;
    joints_.push_back({joint.getName(), limits.at(joint.getName()), prismatic, T_ * T_segment_joint});
    T_ = T_segment_joint.inverse() * to_tip;
  }

  KinematicChain finish(const Eigen::Isometry3d& T_tip_tool) { return {std::move(joints_), T_ * T_tip_tool}; }

 private:
  std::vector<ChainJoint> joints_;
  Eigen::Isometry3d T_ = Eigen::Isometry3d::Identity();
};

/// Walks urdfdom's links depth first, without recursion: a file may hold a very long chain.
class Reader {
 public:
  explicit Reader(const urdf::ModelInterface& model) : model_(model) {
    found_.name = model.getName();
    found_.tree = KDL::Tree(model.getRoot()->name);
    found_.link_names.push_back(model.getRoot()->name);
    found_.links.emplace_back();
    found_.moved_by.push_back(-1);
    add_capsules(*model.getRoot());
    push_children(*model.getRoot(), 0);
    while (!open_.empty()) visit();
    if (found_.links.size() != model.links_.size())
      throw DataError("the URDF has a loop: only " + std::to_string(found_.links.size()) + " of " +
                      std::to_string(model.links_.size()) + " links hang on its root '" + model.getRoot()->name + "'");
  }

  Description take() { return std::move(found_); }

 private:
  struct Open {
    urdf::LinkConstSharedPtr link;
    int parent;
  };

  void push_children(const urdf::Link& link, int index) {
    const auto& children = link.child_links;
    for (auto child = children.rbegin(); child != children.rend(); ++child) open_.push_back({*child, index});
  }

  void visit() {
    const auto [link, parent] = open_.back();
    open_.pop_back();
    const urdf::Joint& joint = *link->parent_joint;
    const Eigen::Isometry3d T = isometry(joint.parent_to_joint_origin_transform, joint.name);
    Description::Link made{.parent = parent, .axis = Eigen::Vector3d::UnitZ(), .T_parent_joint = T};
    const int above = found_.moved_by[static_cast<std::size_t>(parent)];
    if (movable(joint)) add_joint(joint, above, made);
    found_.tree.addSegment(KDL::Segment(link->name, kdl_joint(joint, T), frame(T)), joint.parent_link_name);
    found_.moved_by.push_back(made.joint < 0 ? above : made.joint);
    found_.links.push_back(made);
    found_.link_names.push_back(link->name);
    add_capsules(*link);
    push_children(*link, static_cast<int>(found_.links.size()) - 1);
  }

  void add_joint(const urdf::Joint& joint, int above, Description::Link& link) {
    link.joint = static_cast<int>(found_.joint_names.size());
    link.prismatic = joint.type == urdf::Joint::PRISMATIC;
    link.axis = unit_axis(joint);
    found_.joint_names.push_back(joint.name);
    found_.limits.push_back(joint_limits(joint));
    if (joint.mimic) found_.mimics[joint.name] = joint.mimic->joint_name;
    found_.joint_above.push_back(above);
  }

  void add_capsules(const urdf::Link& link) {
    for (const auto& collision : link.collision_array) {
      if (!collision) continue;
      for (Capsule capsule : capsule_of(*collision, link.name)) {
        capsule.link = static_cast<int>(found_.links.size()) - 1;
        found_.capsules.push_back(capsule);
      }
    }
  }

  const urdf::ModelInterface& model_;
  Description found_;
  std::vector<Open> open_;
};

int index_of(const std::vector<std::string>& names, const std::string& name, const char* kind) {
  const auto at = std::find(names.begin(), names.end(), name);
  if (at == names.end()) throw std::invalid_argument(std::string("the robot has no ") + kind + " '" + name + "'");
  return static_cast<int>(at - names.begin());
}

}  // namespace

RobotModel RobotModel::from_urdf(const std::string& xml) {
  require_plain_xml(xml);
  const auto model = parse(xml);
  require_tree(*model);
  return RobotModel(std::make_shared<const Description>(Reader(*model).take()));
}

RobotModel RobotModel::from_urdf_file(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw DataError("'" + path + "' is no file that can be read");
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) throw DataError("'" + path + "' cannot be read");
  try {
    return from_urdf(text.str());
  } catch (const DataError& why) {
    throw DataError("'" + path + "': " + why.what());
  }
}

const std::string& RobotModel::name() const { return description_->name; }
const std::vector<std::string>& RobotModel::joint_names() const { return description_->joint_names; }
const std::vector<std::string>& RobotModel::link_names() const { return description_->link_names; }
const std::vector<JointLimits>& RobotModel::limits() const { return description_->limits; }
const std::vector<Capsule>& RobotModel::capsules() const { return description_->capsules; }
const std::vector<int>& RobotModel::moved_by() const { return description_->moved_by; }
const std::vector<int>& RobotModel::joint_above() const { return description_->joint_above; }

KinematicChain RobotModel::chain(const std::string& base, const std::string& tip,
                                 const Eigen::Isometry3d& T_tip_tool) const {
  index_of(link_names(), base, "link");
  index_of(link_names(), tip, "link");
  KDL::Chain chain;
  if (!description_->tree.getChain(base, tip, chain))
    throw std::invalid_argument("no chain leads from '" + base + "' to '" + tip + "'");
  std::map<std::string, JointLimits> limits;
  for (std::size_t i = 0; i < joint_names().size(); ++i) limits[joint_names()[i]] = description_->limits[i];
  ChainBuilder builder;
  for (const KDL::Segment& segment : chain.segments) {
    const auto mimic = description_->mimics.find(segment.getJoint().getName());
    if (mimic != description_->mimics.end())
      throw std::invalid_argument("joint '" + mimic->first + "' between '" + base + "' and '" + tip + "' mimics '" +
                                  mimic->second + "': a chain whose joints follow one another is not supported");
    builder.add(segment, limits);
  }
  return builder.finish(T_tip_tool);
}

std::vector<Eigen::Isometry3d> RobotModel::forward(const Eigen::VectorXd& q) const {
  const auto& links = description_->links;
  if (q.size() != static_cast<Eigen::Index>(joint_names().size()))
    throw std::invalid_argument("q has " + std::to_string(q.size()) + " values, must have one for each of the " +
                                std::to_string(joint_names().size()) + " joints");
  require(q.allFinite(), "a value of q is not finite");
  std::vector<Eigen::Isometry3d> poses(links.size(), Eigen::Isometry3d::Identity());
  for (std::size_t i = 1; i < links.size(); ++i) {
    const auto& link = links[i];
    poses[i] = poses[static_cast<std::size_t>(link.parent)] * link.T_parent_joint;
    if (link.joint < 0) continue;
    if (link.prismatic)
      poses[i].translate(link.axis * q[link.joint]);
    else
      poses[i].rotate(Eigen::AngleAxisd(q[link.joint], link.axis));
  }
  return poses;
}

std::vector<int> RobotModel::joint_indices(const std::vector<std::string>& names) const {
  std::vector<int> found;
  for (const std::string& name : names) found.push_back(index_of(joint_names(), name, "joint"));
  return found;
}

}  // namespace lfdcore
