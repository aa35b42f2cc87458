#include "common.hpp"
#include "lfdcore/control/pure_pursuit.hpp"
#include "lfdcore/motion.hpp"

namespace lfdcore {

void bind_pure_pursuit(py::module_& m) {
  py::class_<PurePursuitResult>(m, "PurePursuitResult", "The control point and the twist towards it.")
      .def_readonly("control_point", &PurePursuitResult::control_point,
                    "(2,) g of Alg. 7 [m], in the robot's frame; a read-only view")
      .def_readonly("twist", &PurePursuitResult::twist, "Twist2 [m/s, rad/s]")
      .def_readonly("arc_length", &PurePursuitResult::arc_length, "of the control point along the path [m]")
      .def_readonly("at_end", &PurePursuitResult::at_end,
                    "True if the control point is the path's end, within look_ahead.");
  m.def(
      "pure_pursuit",
      [](const Path& path, double look_ahead, double linear, double max_angular, const Pose2& pose) {
        return pure_pursuit(path, pose, look_ahead, linear, max_angular);
      },
      py::arg("path"), py::arg("look_ahead"), py::arg("linear"), py::arg("max_angular") = MotionLimits{}.max_angular,
      py::kw_only(), py::arg("pose") = Pose2{}, without_gil(),
      "Pure Pursuit (App. E.1, Alg. 7) of a path (N, 2) [m] by a robot at `pose` in the path's frame (default: the "
      "path is in base_link).\n\n"
      "Control point: where the path, after its point closest to the robot, first leaves the circle of radius "
      "look_ahead [m]; its end if it does not leave it; its closest point if it lies wholly outside. Twist: `linear` "
      "[m/s] >= 0 along the arc through it, both reduced together where it would turn faster than max_angular [rad/s]; "
      "a control point behind is turned to in place.\n\n"
      "Raises ValueError for an empty or non-finite path, look_ahead or max_angular that are not positive, or a "
      "negative or non-finite linear.");
}

}  // namespace lfdcore
