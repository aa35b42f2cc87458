#include "common.hpp"
#include "fields.hpp"
#include "lfdcore/control/dynamic_window.hpp"

namespace lfdcore {
namespace {

void bind_config(py::module_& m) {
  using Config = DynamicWindowConfig;
  bind_settings(m, "DynamicWindowConfig",
                "Samples per axis, horizon [s] each twist is held, step [s] between tested poses.",
                Field("linear_samples", &Config::linear_samples), Field("angular_samples", &Config::angular_samples),
                Field("horizon", &Config::horizon, "[s]"), Field("step", &Config::step, "[s]"));
}

}  // namespace

void bind_dynamic_window(py::module_& m) {
  bind_config(m);
  py::class_<DynamicWindowResult>(m, "DynamicWindowResult", "The chosen twist and where it leads.")
      .def_readonly("twist", &DynamicWindowResult::twist, "Twist2 [m/s, rad/s]")
      .def_readonly("feasible", &DynamicWindowResult::feasible, "False: every candidate collides, `twist` brakes.")
      .def_readonly("end_point", &DynamicWindowResult::end_point,
                    "(2,) where `twist` held over the horizon leads, base_link [m]; a read-only view")
      .def_readonly("cost", &DynamicWindowResult::cost, "distance [m] of end_point to the goal; inf if not feasible");
  m.def("solve_dynamic_window", &solve_dynamic_window, py::arg("current"), py::arg("goal"), py::arg("obstacles"),
        py::arg("footprint") = Footprint{}, py::arg("limits") = MotionLimits{},
        py::arg("config") = DynamicWindowConfig{}, py::arg("wanted") = Twist2{},
        py::arg("period") = CommandTiming{}.period, without_gil(),
        "Dynamic Window Approach (App. E.2, Alg. 8; ERRATA 47): of the twists that `limits` let the chair reach from "
        "`current` within a `period` [s] between two commands, the one that ends nearest to goal (2,) [m] after the "
        "horizon without the "
        "footprint touching `obstacles` at any step; all in base_link. Of those that end alike (all turns on the spot "
        "do) the one nearest to `wanted`. If all collide it brakes at the limit (feasible = False).\n\nRaises "
        "ValueError for a non-finite twist or goal or a period that is not positive.");
}

}  // namespace lfdcore
