#include "common.hpp"
#include "fields.hpp"
#include "lfdcore/control/footprint_rollout.hpp"

namespace lfdcore {
namespace {

void bind_config(py::module_& m) {
  bind_settings(m, "FootprintRolloutConfig", "How a path's pursuit is rolled out.",
                Field("look_ahead", &FootprintRolloutConfig::look_ahead, "of the pursuit [m] (Sec. 3.4.3)"),
                Field("linear", &FootprintRolloutConfig::linear, "speed wanted along the path [m/s]"),
                Field("duration", &FootprintRolloutConfig::duration, "how far ahead in time [s]"),
                Field("step", &FootprintRolloutConfig::step, "between commands [s]"));
}

void bind_rollout(py::module_& m) {
  py::class_<FootprintRollout>(m, "FootprintRollout", "What following a path would do; see rollout_pursuit.")
      .def_readonly("poses", &FootprintRollout::poses,
                    "(T, 3) x, y [m], yaw [rad] each step from the start on, in the start's base_link, a view")
      .def_readonly("time_to_contact", &FootprintRollout::time_to_contact, "[s], inf if there is none")
      .def_readonly("min_clearance", &FootprintRollout::min_clearance,
                    "least distance [m] of the footprint at these poses from a point, 0 at a contact")
      .def_readonly("reached_end", &FootprintRollout::reached_end, "the chair came to the path's end");
}

}  // namespace

void bind_footprint_rollout(py::module_& m) {
  bind_config(m);
  bind_rollout(m);
  m.def("rollout_pursuit", &rollout_pursuit, py::arg("path"), py::arg("obstacles"), py::arg("footprint"),
        py::arg("limits") = MotionLimits{}, py::arg("twist") = Twist2{}, py::kw_only(),
        py::arg("config") = FootprintRolloutConfig{}, without_gil(),
        "Follow a path (N, 2) [m] in base_link from its origin by pure pursuit (App. E.1), the speeds changing as\n"
        "`limits` allow from `twist` on, braking so as to stop at the path's end. Ends at a contact (the last pose is\n"
        "the one before it), at the path's end or after config.duration. The contact test is conservative between\n"
        "steps: never later than the true contact, and a gap below 5 mm may count. Obstacles are in base_link too;\n"
        "for a safety margin pass footprint.grown(margin). ValueError for a path that is empty or not finite.");
  m.def(
      "time_to_contact", &time_to_contact, py::arg("twist"), py::arg("obstacles"), py::arg("footprint"),
      py::arg("horizon"), without_gil(),
      "Time [s] until a body that keeps `twist` from base_link's origin touches a point, inf if not within `horizon`\n"
      "[s]; never later than the true contact. ValueError beyond 10 m/s, 10 rad/s or 600 s.");
}

}  // namespace lfdcore
