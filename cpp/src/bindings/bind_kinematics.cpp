#include "arrays.hpp"
#include "common.hpp"
#include "fields.hpp"
#include "lfdcore/error.hpp"
#include "lfdcore/kinematics/joint_trajectory.hpp"

namespace lfdcore {
namespace {

using Matrix4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

Eigen::MatrixXd limit_rows(const RobotModel& model) {
  Eigen::MatrixXd rows(model.limits().size(), 3);
  for (std::size_t i = 0; i < model.limits().size(); ++i) {
    const JointLimits& limits = model.limits()[i];
    rows.row(static_cast<Eigen::Index>(i)) << limits.lower, limits.upper, limits.velocity;
  }
  return rows;
}

Matrix4 link_pose(const RobotModel& model, const Eigen::VectorXd& q, const std::string& link) {
  const auto& names = model.link_names();
  const auto at = std::find(names.begin(), names.end(), link);
  require(at != names.end(), "the robot has no link '" + link + "'");
  return model.forward(q)[static_cast<std::size_t>(at - names.begin())].matrix();
}

using LinkCapsule = std::tuple<std::string, Eigen::Vector3d, Eigen::Vector3d, double>;

std::vector<LinkCapsule> link_capsules(const RobotModel& model) {
  std::vector<LinkCapsule> found;
  for (const Capsule& c : model.capsules())
    found.emplace_back(model.link_names()[static_cast<std::size_t>(c.link)], c.a, c.b, c.radius);
  return found;
}

void bind_chain(py::module_& m) {
  py::class_<KinematicChain>(m, "KinematicChain",
                             "The joints from a base link to a tool, n of them; made by RobotModel.chain().")
      .def("__len__", &KinematicChain::size)
      .def_property_readonly("joint_names", &KinematicChain::joint_names)
      .def_property_readonly("lower", &KinematicChain::lower, "(n,) [rad or m], -inf of a continuous joint")
      .def_property_readonly("upper", &KinematicChain::upper, "(n,) [rad or m], inf of a continuous joint")
      .def_property_readonly("velocity", &KinematicChain::velocity, "(n,) [rad/s or m/s]")
      .def_property_readonly("reach", &KinematicChain::reach,
                             "the tool is never farther than this from the first joint [m]; a bound")
      .def(
          "forward",
          [](const KinematicChain& chain, const Eigen::VectorXd& q) -> Matrix4 { return chain.forward(q).matrix(); },
          py::arg("q"),
          "T_base_tool (4, 4) at q (n,), also outside the limits. ValueError for another length or values that are not "
          "finite.")
      .def("jacobian", &KinematicChain::jacobian, py::arg("q"),
           "(6, n): linear [m/s], then angular [rad/s] velocity of the tool's origin in the base frame by joint "
           "velocity. Errors like forward().");
}

void bind_model(py::module_& m) {
  py::class_<RobotModel>(m, "RobotModel",
                         "A robot read from a URDF (urdfdom, KDL). Joints and links come depth first from the root, "
                         "siblings by the names of their joints; a mimic joint is a joint of its own.")
      .def_static(
          "from_urdf", &RobotModel::from_urdf, py::arg("xml"), without_gil(),
          "From a URDF's text. DataError for what is no URDF of a tree of fixed, revolute, continuous and\n"
          "prismatic joints: malformed or truncated XML, XML with a document type or entities, above 16 MiB\n"
          "or 2000 links, links without names or with two parents, loops, joints without limits or with axes of\n"
          "length zero.")
      .def_static(
          "from_urdf_file",
          [](const py::object& path) {
            const auto text = py::module_::import("os").attr("fspath")(path).cast<std::string>();
            const py::gil_scoped_release release;
            return RobotModel::from_urdf_file(text);
          },
          py::arg("path"), "The same from a file; also DataError where it cannot be read.")
      .def_property_readonly("name", &RobotModel::name)
      .def_property_readonly("joint_names", &RobotModel::joint_names, "N movable joints")
      .def_property_readonly(
          "collision_shapes", &link_capsules,
          "(link, begin (3,), end (3,) [m, in the link's frame], radius [m]) of every sphere and of\n"
          "the capsules that contain cylinders and boxes; meshes are not read")
      .def_property_readonly("link_names", &RobotModel::link_names, "the root first")
      .def_property_readonly("limits", &limit_rows,
                             "(N, 3) lower, upper [rad or m; -inf, inf of a continuous joint], velocity [rad/s or m/s]")
      .def(
          "chain",
          [](const RobotModel& model, const std::string& base, const std::string& tip, const Matrix4& T_tip_tool) {
            return model.chain(base, tip, rigid_transform(T_tip_tool, "T_tip_tool"));
          },
          py::arg("base"), py::arg("tip"), py::arg("T_tip_tool") = Matrix4(Matrix4::Identity()),
          "The chain from `base` to the tool that T_tip_tool (4, 4) places in the frame of `tip`, both names of\n"
          "links. ValueError for unknown links, a chain without movable joints or no rigid transform.")
      .def("forward", &link_pose, py::arg("q"), py::arg("link"),
           "T_root_link (4, 4) at q (N,), joints as in joint_names. ValueError for another length, values that are not "
           "finite or an unknown link.");
}

using Config = InverseKinematicsConfig;

void bind_ik_config(py::module_& m) {
  bind_settings(
      m, "InverseKinematicsConfig", "Settings of the inverse kinematics.",
      Field("position_tolerance", &Config::position_tolerance, "of a solution [m]"),
      Field("rotation_tolerance", &Config::rotation_tolerance, "of a solution [rad]"),
      Field("iterations", &Config::iterations, "at most, of one descent"),
      Field("restarts", &Config::restarts, "descents at most, besides that from a seed; 0: only from the seed"),
      Field("postures", &Config::postures, "fixed ones that restarts are chosen from"),
      Field("damping", &Config::damping, "times the squared error, of the normal equations"));
}

void bind_ik(py::module_& m) {
  using Result = InverseKinematicsResult;
  py::class_<Result>(m, "InverseKinematicsResult", "What a search for joint positions came to.")
      .def_readonly("solved", &Result::solved, "within both tolerances")
      .def_readonly("joints", &Result::joints,
                    "(n,) inside the limits; unless solved, the nearest that was met; a view")
      .def_readonly("position_error", &Result::position_error, "[m]")
      .def_readonly("rotation_error", &Result::rotation_error, "[rad]")
      .def_readonly("restarts", &Result::restarts, "descents made after the first")
      .def_readonly("iterations", &Result::iterations, "of all descents together");
  py::class_<InverseKinematics>(
      m, "InverseKinematics",
      "Solver for one chain. Descents are Levenberg-Marquardt's, damped in proportion to the squared error (Sugihara\n"
      "2011), joints that would leave their limits held at them and the rest solved again. Restarts begin at those of\n"
      "a fixed set of postures (mid-range and Halton's points of the joint space, whatever the pose) whose tools are\n"
      "nearest to the pose. Deterministic; may be shared between threads.")
      .def(py::init<KinematicChain, const Config&>(), py::arg("chain"), py::kw_only(), py::arg("config") = Config{},
           without_gil())
      .def(
          "solve",
          [](const InverseKinematics& solver, const Matrix4& T_base_tool, const std::optional<Eigen::VectorXd>& seed) {
            return solver.solve(rigid_transform(T_base_tool, "T_base_tool"), seed);
          },
          py::arg("T_base_tool"), py::arg("seed") = std::nullopt, without_gil(),
          "For the pose T_base_tool (4, 4): from `seed` (n,) first, where one is given (brought inside the limits),\n"
          "then by restarts; beyond the length of the stretched arm one descent must do. ValueError for no rigid\n"
          "transform or a seed of another length.");
  m.def(
      "solve_inverse_kinematics",
      [](const KinematicChain& chain, const Matrix4& T_base_tool, const Config& config,
         const std::optional<Eigen::VectorXd>& seed) {
        return solve_inverse_kinematics(chain, rigid_transform(T_base_tool, "T_base_tool"), config, seed);
      },
      py::arg("chain"), py::arg("T_base_tool"), py::arg("config") = Config{}, py::arg("seed") = std::nullopt,
      without_gil(), "One pose with a solver of its own (1 ms to make); see InverseKinematics.solve.");
}

py::tuple named(const SelfCollision& robot, const SelfDistance& nearest) {
  if (nearest.first < 0) return py::make_tuple(nearest.distance, py::none());
  const auto& links = robot.model().link_names();
  return py::make_tuple(nearest.distance, py::make_tuple(links[static_cast<std::size_t>(nearest.first)],
                                                         links[static_cast<std::size_t>(nearest.second)]));
}

void bind_self_collision(py::module_& m) {
  py::class_<SelfCollision>(
      m, "SelfCollision",
      "How far a robot's links are from each other: spheres as they are, cylinders and boxes as the capsules that\n"
      "contain them. Not compared: links that at most two joints move against each other (their limits must keep them\n"
      "apart), pairs that overlap in every one of 200 fixed random postures, and `ignored` pairs of names.")
      .def(py::init<RobotModel, const std::vector<SelfCollision::Names>&>(), py::arg("model"),
           py::arg("ignored") = std::vector<SelfCollision::Names>{}, without_gil(),
           "ValueError for unknown links or a robot without collision shapes (meshes are not read).")
      .def_property_readonly(
          "pairs",
          [](const SelfCollision& robot) {
            const auto& links = robot.model().link_names();
            std::vector<SelfCollision::Names> names;
            for (const auto& [a, b] : robot.pairs())
              names.emplace_back(links[static_cast<std::size_t>(a)], links[static_cast<std::size_t>(b)]);
            return names;
          },
          "the names of the links that are compared")
      .def(
          "distance", [](const SelfCollision& robot, const Eigen::VectorXd& q) { return robot.distance(q).distance; },
          py::arg("q"), "Smallest distance [m] at q (N,) of all of the robot's joints, below 0 where links overlap.")
      .def(
          "nearest",
          [](const SelfCollision& robot, const Eigen::VectorXd& q) { return named(robot, robot.distance(q)); },
          py::arg("q"), "The smallest distance [m] and the names of the two links.");
}

void bind_follow_config(py::module_& m) {
  using Follow = FollowConfig;
  bind_settings(m, "FollowConfig", "Settings of follow_poses.",
                Field("inverse_kinematics", &Follow::inverse_kinematics, "of each pose"),
                Field("centring", &Follow::centring, "rate at which free joints tend to mid-range [1/s]"),
                Field("clearance", &Follow::clearance, "that links must keep from each other [m]"),
                Field("avoidance", &Follow::avoidance, "from this distance of links on, free joints part them [m]"),
                Field("avoidance_speed", &Follow::avoidance_speed, "of that motion where links touch [rad/s]"),
                Field("largest_step", &Follow::largest_step,
                      "of a joint from sample to sample; more counts as a jump [rad or m]"),
                Field("velocity_share", &Follow::velocity_share, "of the velocity limits that is used"),
                Field("smoothing", &Follow::smoothing, "slowing down spreads this far to both sides [s]"),
                Field("starts", &Follow::starts, "first postures tried where none is given"));
}

void bind_follow_result(py::module_& m) {
  py::class_<JointTrajectory>(m, "JointTrajectory", "Positions and velocities of n joints at T times.")
      .def_readonly("time", &JointTrajectory::time, "(T,) [s], increasing; a view")
      .def_readonly("positions", &JointTrajectory::positions, "(T, n) [rad or m]; a view")
      .def_readonly("velocities", &JointTrajectory::velocities, "(T, n) [rad/s or m/s]; a view");
  py::class_<FollowResult>(m, "FollowResult", "What following a trajectory of the tool came to.")
      .def_property_readonly(
          "outcome", [](const FollowResult& r) { return to_string(r.outcome); },
          "'followed' | 'out_of_reach' (no posture inside the limits reaches the pose) | 'no_continuous_path' (one "
          "does, but not without a jump) | 'self_collision' (links nearer than the clearance, free joints cannot help)")
      .def_readonly("trajectory", &FollowResult::trajectory, "unless followed, only what comes before the failure")
      .def_readonly("first_failure", &FollowResult::first_failure, "index of the first pose not followed, or None")
      .def_readonly("position_error", &FollowResult::position_error, "largest [m]")
      .def_readonly("rotation_error", &FollowResult::rotation_error, "largest [rad]")
      .def_readonly("clearance", &FollowResult::clearance, "smallest distance of links [m]; inf without self_collision")
      .def_readonly("slowdown", &FollowResult::slowdown, "duration over the wanted duration")
      .def_property_readonly(
          "nearest_links",
          [](const FollowResult& r) {
            using Pair = std::optional<std::pair<int, int>>;
            return r.nearest.first < 0 ? Pair{} : Pair{{r.nearest.first, r.nearest.second}};
          },
          "indices into RobotModel.link_names of the two links at `clearance`, or None");
}

std::vector<Eigen::Isometry3d> poses_from(const Doubles& array) {
  require(array.ndim() == 3 && array.shape(1) == 4 && array.shape(2) == 4, "T_base_tool must be (T, 4, 4)");
  std::vector<Eigen::Isometry3d> poses;
  poses.reserve(static_cast<std::size_t>(array.shape(0)));
  for (py::ssize_t i = 0; i < array.shape(0); ++i) {
    const Eigen::Map<const Matrix4> matrix(array.data(i, 0, 0));
    poses.push_back(rigid_transform(matrix, "T_base_tool[" + std::to_string(i) + "]"));
  }
  return poses;
}

FollowResult follow(const KinematicChain& chain, const Eigen::VectorXd& time, const Doubles& T_base_tool,
                    const std::optional<Eigen::VectorXd>& start, const FollowConfig& config,
                    const std::optional<SelfCollision>& self_collision,
                    const std::optional<py::array_t<double>>& posture) {
  const auto poses = poses_from(T_base_tool);
  RowMatrix rows;
  if (posture) {
    const bool one = posture->ndim() == 1;
    rows = one ? RowMatrix(posture->cast<Eigen::VectorXd>().transpose()) : posture->cast<RowMatrix>();
  }
  require(self_collision.has_value() == posture.has_value(), "self_collision and posture belong together");
  std::optional<Surroundings> surroundings;
  if (self_collision) surroundings.emplace(Surroundings{*self_collision, rows});
  const py::gil_scoped_release release;
  return follow_poses(chain, time, poses, start, config, surroundings);
}

void bind_follow(py::module_& m) {
  m.def(
      "follow_poses", &follow, py::arg("chain"), py::arg("time"), py::arg("T_base_tool"),
      py::arg("start") = std::nullopt, py::arg("config") = FollowConfig{}, py::kw_only(),
      py::arg("self_collision") = std::nullopt, py::arg("posture") = std::nullopt,
      "Joint positions and velocities that follow poses T_base_tool (T, 4, 4) at `time` (T,) [s], sample by sample\n"
      "from the last posture, inside the position limits; joints that the pose leaves free tend to mid-range and away\n"
      "from self-collision. Where a joint would be faster than its limit, time is stretched there, smoothly: nothing\n"
      "is clipped, the path stays, it takes longer. From `start` (n,) (the first pose's posture is the one found from\n"
      "there), or from the best of several first postures. With self_collision, `posture` says where the robot's\n"
      "other joints are: (N,) or (T, N), the chain's own are replaced. Failure is in the result. ValueError for fewer\n"
      "than 2 poses, times that do not increase, other lengths, velocity limits of 0 or values that are not finite.");
  m.def(
      "slow_down", &slow_down, py::arg("time"), py::arg("positions"), py::arg("velocity"), py::arg("smoothing") = 0.2,
      without_gil(),
      "Times (T,) [s], from time[0] on, at which positions (T, n) keep inside velocity limits (n,): each interval\n"
      "takes as long as before or longer, stretches spread smoothly over `smoothing` [s] to both sides. For two arms:\n"
      "stack their positions. ValueError like follow_poses.");
  m.def("joint_velocities", &joint_velocities, py::arg("time"), py::arg("positions"), without_gil(),
        "(T, n): slopes of the parabolas through each of positions (T, n) and its neighbours, of the chords at the\n"
        "ends; never above the fastest chord. ValueError like follow_poses.");
}

}  // namespace

void bind_kinematics(py::module_& m) {
  bind_chain(m);
  bind_model(m);
  bind_ik_config(m);
  bind_ik(m);
  bind_self_collision(m);
  bind_follow_config(m);
  bind_follow_result(m);
  bind_follow(m);
}

}  // namespace lfdcore
