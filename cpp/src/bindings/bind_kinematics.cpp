#include "common.hpp"
#include "lfdcore/error.hpp"
#include "lfdcore/kinematics/inverse_kinematics.hpp"
#include "lfdcore/kinematics/robot_model.hpp"

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
      .def_static("from_urdf", &RobotModel::from_urdf, py::arg("xml"), without_gil(),
                  "From a URDF's text. DataError for what is no URDF of a tree of fixed, revolute, continuous and\n"
                  "prismatic joints: malformed or truncated XML, XML with a document type or entities, above 16 MiB,\n"
                  "links without names or with two parents, loops, joints without limits or with axes of length zero.")
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
      .def_property_readonly("link_names", &RobotModel::link_names, "the root first")
      .def_property_readonly("limits", &limit_rows,
                             "(N, 3) lower, upper [rad or m; -inf, inf of a continuous joint], velocity [rad/s or m/s]")
      .def(
          "chain",
          [](const RobotModel& model, const std::string& base, const std::string& tip, const Matrix4& T_tip_tool) {
            return model.chain(base, tip, rigid_transform(T_tip_tool, "T_tip_tool"));
          },
          py::arg("base"), py::arg("tip"), py::arg("T_tip_tool") = Matrix4(Matrix4::Identity()),
          "The chain from `base` to the tool that T_tip_tool (4, 4) places in the frame of `tip`, both names of "
          "links.\n"
          "ValueError for unknown links, a chain without movable joints or no rigid transform.")
      .def("forward", &link_pose, py::arg("q"), py::arg("link"),
           "T_root_link (4, 4) at q (N,), joints as in joint_names. ValueError for another length, values that are not "
           "finite or an unknown link.");
}

using Config = InverseKinematicsConfig;

Config make_config(double position_tolerance, double rotation_tolerance, int iterations, int restarts, int postures,
                   double damping) {
  const Config made{position_tolerance, rotation_tolerance, iterations, restarts, postures, damping};
  validate(made);
  return made;
}

void bind_ik_config(py::module_& m) {
  const Config c;
  py::class_<Config>(m, "InverseKinematicsConfig", "Settings of the inverse kinematics.")
      .def(py::init(&make_config), py::kw_only(), py::arg("position_tolerance") = c.position_tolerance,
           py::arg("rotation_tolerance") = c.rotation_tolerance, py::arg("iterations") = c.iterations,
           py::arg("restarts") = c.restarts, py::arg("postures") = c.postures, py::arg("damping") = c.damping)
      .def_readonly("position_tolerance", &Config::position_tolerance, "of a solution [m]")
      .def_readonly("rotation_tolerance", &Config::rotation_tolerance, "of a solution [rad]")
      .def_readonly("iterations", &Config::iterations, "at most, of one descent")
      .def_readonly("restarts", &Config::restarts, "descents at most, besides that from a seed; 0: only from the seed")
      .def_readonly("postures", &Config::postures, "fixed ones that restarts are chosen from")
      .def_readonly("damping", &Config::damping, "times the squared error, of the normal equations")
      .def(py::pickle(
          [](const Config& s) {
            return py::make_tuple(s.position_tolerance, s.rotation_tolerance, s.iterations, s.restarts, s.postures,
                                  s.damping);
          },
          [](const py::tuple& t) {
            return make_config(t[0].cast<double>(), t[1].cast<double>(), t[2].cast<int>(), t[3].cast<int>(),
                               t[4].cast<int>(), t[5].cast<double>());
          }));
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
      "Solver for one chain. Descents are Levenberg-Marquardt's, damped in proportion to the squared error\n"
      "(Sugihara 2011), joints that would leave their limits held at them and the rest solved again. Restarts begin "
      "at\n"
      "those of a fixed set of postures (mid-range and Halton's points of the joint space, whatever the pose) whose\n"
      "tools are nearest to the pose. Deterministic; may be shared between threads.")
      .def(py::init<KinematicChain, const Config&>(), py::arg("chain"), py::kw_only(), py::arg("config") = Config{},
           without_gil())
      .def(
          "solve",
          [](const InverseKinematics& solver, const Matrix4& T_base_tool, const std::optional<Eigen::VectorXd>& seed) {
            return solver.solve(rigid_transform(T_base_tool, "T_base_tool"), seed);
          },
          py::arg("T_base_tool"), py::arg("seed") = std::nullopt, without_gil(),
          "For the pose T_base_tool (4, 4): from `seed` (n,) first, where one is given (brought inside the limits), "
          "then\n"
          "by restarts; beyond the length of the stretched arm one descent must do. ValueError for no rigid transform\n"
          "or a seed of another length.");
  m.def(
      "solve_inverse_kinematics",
      [](const KinematicChain& chain, const Matrix4& T_base_tool, const Config& config,
         const std::optional<Eigen::VectorXd>& seed) {
        return solve_inverse_kinematics(chain, rigid_transform(T_base_tool, "T_base_tool"), config, seed);
      },
      py::arg("chain"), py::arg("T_base_tool"), py::arg("config") = Config{}, py::arg("seed") = std::nullopt,
      without_gil(), "One pose with a solver of its own (1 ms to make); see InverseKinematics.solve.");
}

}  // namespace

void bind_kinematics(py::module_& m) {
  bind_chain(m);
  bind_model(m);
  bind_ik_config(m);
  bind_ik(m);
}

}  // namespace lfdcore
