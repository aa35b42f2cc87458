#include "common.hpp"
#include "fields.hpp"
#include "lfdcore/control/supervisor.hpp"

namespace lfdcore {
namespace {

using Config = SupervisorConfig;

void bind_config(py::module_& m) {
  bind_settings(m, "SupervisorConfig", "How far ahead the supervisor looks and how near it lets the chair come.",
                Field("period", &Config::period, "[s] until the next command can take effect"),
                Field("reaction", &Config::reaction, "[s] until it surely has: period + latency"),
                Field("margin", &Config::margin, "[m] to keep between footprint and points"),
                Field("slow_margin", &Config::slow_margin, "[m] the same while slow"),
                Field("slow_linear", &Config::slow_linear, "[m/s] slow: command and chair at most this fast ..."),
                Field("slow_angular", &Config::slow_angular, "[rad/s] ... and turning at most this fast"),
                Field("overlap", &Config::overlap, "[m] points this deep inside the footprint are taken for noise"),
                Field("least_scale", &Config::least_scale, "share down to which a twist is slowed down first"),
                Field("linear_samples", &Config::linear_samples, "speeds tried, from the wanted one to 0"),
                Field("angular_samples", &Config::angular_samples, "turning rates tried, around the wanted one"));
}

}  // namespace

void bind_supervisor(py::module_& m) {
  bind_config(m);
  py::class_<SupervisorResult>(m, "SupervisorResult", "The command to send and what was done to the wanted one.")
      .def_readonly("twist", &SupervisorResult::twist, "Twist2 to send [m/s, rad/s]")
      .def_readonly("scale", &SupervisorResult::scale, "its size as a share of the wanted one's (1 if that is 0)")
      .def_readonly("changed", &SupervisorResult::changed, "it is not the wanted one")
      .def_readonly("stopped", &SupervisorResult::stopped, "it is 0 though the wanted one is not")
      .def_readonly("margin", &SupervisorResult::margin,
                    "[m] that was required; less than configured if the chair is nearer already");
  py::class_<Supervisor>(
      m, "Supervisor",
      "Lets commands through that leave the chair able to stop: the admissible command nearest to the wanted one.\n\n"
      "A command is admissible if the chair, from its current twist, follows it for `period`, and also for `reaction`, "
      "and then brakes to a standstill, without any point coming nearer to the footprint than the margin. Tried in "
      "turn: the wanted twist; its scaled copies down to least_scale; twists not faster ahead, by their distance "
      "hypot(dv / max_linear, dw / max_angular) to it, while nearer than 0; 0. Where points are nearer than the margin "
      "already, the present clearance is the margin, so that the chair can drive away from them.\n\n"
      "Raises ValueError for invalid limits or config. Not for use from two threads at once.")
      .def(py::init<const Footprint&, const MotionLimits&, const Config&>(), py::arg("footprint") = Footprint{},
           py::arg("limits") = MotionLimits{}, py::arg("config") = Config{})
      // Keeps the GIL: its workspace belongs to one caller at a time, and a call is short.
      .def("filter", &Supervisor::filter, py::arg("wanted"), py::arg("current"), py::arg("obstacles"),
           "The command to send. `current`: the chair's twist when it takes effect; `obstacles` in base_link. Without "
           "points everything is admissible: a caller whose scan is stale must want 0.\n\nRaises ValueError for a "
           "non-finite twist or a current one beyond 10 times the limits.")
      .def_property_readonly("footprint", &Supervisor::footprint)
      .def_property_readonly("limits", &Supervisor::limits)
      .def_property_readonly("config", &Supervisor::config)
      .def(py::pickle([](const Supervisor& s) { return py::make_tuple(s.footprint(), s.limits(), s.config()); },
                      [](const py::tuple& t) {
                        return Supervisor(t[0].cast<Footprint>(), t[1].cast<MotionLimits>(), t[2].cast<Config>());
                      }));
}

}  // namespace lfdcore
