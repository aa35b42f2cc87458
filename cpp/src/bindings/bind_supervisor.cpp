#include "common.hpp"
#include "fields.hpp"
#include "lfdcore/control/supervisor.hpp"

namespace lfdcore {
namespace {

using Config = SupervisorConfig;

void bind_config(py::module_& m) {
  bind_settings(m, "CommandTiming", "When commands come: a chair's own, not the supervisor's to choose.",
                Field("period", &CommandTiming::period, "[s] between two commands"),
                Field("jitter", &CommandTiming::jitter, "[s] by which the next command may come late"));
  bind_settings(
      m, "SupervisorConfig", "How far ahead the supervisor looks and how near it lets the chair come.",
      Field("margin", &Config::margin, "[m] to keep between footprint and points at speed"),
      Field("least_margin", &Config::least_margin, "[m] ... and at standstill; between them in proportion"),
      Field("margin_linear", &Config::margin_linear, "[m/s] from which `margin` is kept ..."),
      Field("margin_angular", &Config::margin_angular, "[rad/s] ... or from this turning rate"),
      Field("passing_margin", &Config::passing_margin, "[m] beside the way of a chair that creeps straight on"),
      Field("dynamics_error", &Config::dynamics_error,
            "share by which accelerations and braking may be quicker or slower than the limits say"),
      Field("speed_error", &Config::speed_error,
            "share by which speeds over ground may differ from odometry and command"),
      Field("obstacle_speed", &Config::obstacle_speed, "[m/s] at which points may come nearer"),
      Field("walking_speed", &Config::walking_speed, "[m/s] ... and those of who walks"),
      Field("creep_linear", &Config::creep_linear, "[m/s] creeping: ahead at most this fast"),
      Field("creep_reverse", &Config::creep_reverse, "[m/s] ... backwards"),
      Field("creep_angular", &Config::creep_angular, "[rad/s] ... and turning; so, unseen space may be entered"),
      Field("least_scale", &Config::least_scale, "share down to which a twist is slowed down first"),
      Field("linear_samples", &Config::linear_samples, "speeds tried, from the wanted one to 0"),
      Field("angular_samples", &Config::angular_samples, "turning rates tried, around the wanted one"));
}

SupervisorResult filter(Supervisor& supervisor, const Twist2& wanted, const Twist2& current,
                        const ObstaclePoints& obstacles, const std::vector<std::pair<Twist2, double>>& pending,
                        double age, std::optional<std::reference_wrapper<const ObstaclePoints>> unseen,
                        std::optional<std::reference_wrapper<const ObstaclePoints>> walkers) {
  std::vector<TimedTwist> commands;
  for (const auto& [twist, duration] : pending) commands.push_back({twist, duration});
  return supervisor.filter(wanted, current, obstacles, commands, age, unseen ? unseen->get() : ObstaclePoints(),
                           walkers ? walkers->get() : ObstaclePoints());
}

}  // namespace

void bind_supervisor(py::module_& m) {
  bind_config(m);
  py::class_<SupervisorResult>(m, "SupervisorResult", "The command to send and what was done to the wanted one.")
      .def_readonly("twist", &SupervisorResult::twist, "Twist2 to send [m/s, rad/s]")
      .def_readonly("scale", &SupervisorResult::scale, "its stick size as a share of the wanted one's (1 if that is 0)")
      .def_readonly("changed", &SupervisorResult::changed, "it is not the wanted one")
      .def_readonly("stopped", &SupervisorResult::stopped, "it is 0 though the wanted one is not")
      .def_readonly("keeps", &SupervisorResult::keeps,
                    "it is admissible; False: it is 0, and even stopping may bring a point nearer than it has to keep")
      .def_readonly("margin", &SupervisorResult::margin,
                    "[m] that was required of points that were not nearer already, beyond their uncertainty");
  py::class_<Supervisor>(
      m, "Supervisor",
      "Lets commands through that leave the chair able to stop: the admissible command nearest to the wanted one. What "
      "it promises, and on what assumptions: docs/safety.md.\n\n"
      "A command is admissible if the chair, from its current twist, obeys the pending commands, follows this one for "
      "the timing's `period`, up to `jitter` longer, and brakes to a standstill, without any point coming nearer to "
      "the footprint "
      "than it has to keep, whatever the errors of the config allow. A point has to keep the margin (by the speed) + "
      "its uncertainty + obstacle_speed (age + time until standstill), but never more than its distance now, below 0 "
      "inside the footprint: a point that is too near must not come nearer, and says nothing about others. A chair "
      "that "
      "creeps straight on may pass what is surely beside its way, and a wall that touches its side. Tried in turn: the "
      "wanted twist; its scaled copies down to least_scale; other twists that may replace it, by their "
      "distance to it; 0.\n\n"
      "Raises ValueError for invalid limits, config or timing. Not for use from two threads at once.")
      .def(py::init<const Footprint&, const MotionLimits&, const Config&, const CommandTiming&>(),
           py::arg("footprint") = Footprint{}, py::arg("limits") = MotionLimits{}, py::arg("config") = Config{},
           py::arg("timing") = CommandTiming{})
      // Keeps the GIL: its workspace belongs to one caller at a time, and a call is short.
      .def(
          "filter", &filter, py::arg("wanted"), py::arg("current"), py::arg("obstacles"), py::kw_only(),
          py::arg("pending") = std::vector<std::pair<Twist2, double>>{}, py::arg("age") = 0.0,
          py::arg("unseen") = py::none(), py::arg("walkers") = py::none(),
          "The command to send.\n\n"
          "- current: the chair's twist now.\n"
          "- obstacles: in base_link, now. Without points everything is admissible: a caller whose scan is stale must "
          "want 0.\n"
          "- pending: (twist, duration [s]) of the commands already given, in the order in which they act from now on, "
          "before this one does.\n"
          "- age [s] of the points; counts with obstacle_speed and walking_speed.\n"
          "- unseen: places in base_link at the border of space that no beam has seen. A command faster than the creep "
          "speeds is admissible only if its roll-outs keep them out of the footprint. None: as if all were seen.\n"
          "- walkers: points in base_link of who walks about: they may come nearer at walking_speed. None: nobody.\n\n"
          "Raises ValueError for a non-finite twist, a current or pending one beyond 10 times the limits, a duration "
          "or "
          "an age that is not in [0, 10] s.")
      .def("reset", &Supervisor::reset,
           "Forgets how near the walls were that touch the chair's sides. A wanted twist of 0 does so, too.")
      .def(
          "may_replace", &Supervisor::may_replace, py::arg("wanted"), py::arg("twist"),
          "Whether a twist may stand in for the wanted one (within the limits), as far as the driver is concerned. "
          "Where a turn on the spot is wanted (linear 0): a slower turn to the same side. Else: linear between 0 and "
          "the wanted one; a stick size hypot(linear / max_linear or max_reverse, angular / max_angular) no larger "
          "than the wanted one's; not to the side opposite to the one asked for; nearer to the wanted twist than 0 is.")
      .def_property_readonly("footprint", &Supervisor::footprint)
      .def_property_readonly("limits", &Supervisor::limits)
      .def_property_readonly("config", &Supervisor::config)
      .def_property_readonly("timing", &Supervisor::timing)
      .def(py::pickle(
          [](const Supervisor& s) { return py::make_tuple(s.footprint(), s.limits(), s.config(), s.timing()); },
          [](const py::tuple& t) {
            return Supervisor(t[0].cast<Footprint>(), t[1].cast<MotionLimits>(), t[2].cast<Config>(),
                              t[3].cast<CommandTiming>());
          }));
}

}  // namespace lfdcore
