#include <sstream>

#include "common.hpp"
#include "lfdcore/simulation/driving_world.hpp"

namespace lfdcore {
namespace {

void bind_contact_config(py::module_& m) {
  const ContactConfig c;
  py::class_<ContactConfig>(
      m, "ContactConfig",
      "How the body behaves where it touches: friction (Coulomb's coefficient), skid_resistance (how much harder than "
      "rolling it is to push the wheels sideways, a ratio of masses), skid_time [s] in which they grip again, "
      "gyration_radius [m]; a contact lasts until the "
      "body has been clear of everything by release_gap [m] for release_time [s], so that chattering counts once.")
      .def(py::init([](double friction, double skid_resistance, double skid_time, double gyration_radius,
                       double release_gap, double release_time) {
             const ContactConfig made{friction, skid_resistance, skid_time, gyration_radius, release_gap, release_time};
             validate(made);
             return made;
           }),
           py::kw_only(), py::arg("friction") = c.friction, py::arg("skid_resistance") = c.skid_resistance,
           py::arg("skid_time") = c.skid_time, py::arg("gyration_radius") = c.gyration_radius,
           py::arg("release_gap") = c.release_gap, py::arg("release_time") = c.release_time)
      .def_readonly("friction", &ContactConfig::friction, "Coulomb's coefficient")
      .def_readonly("skid_resistance", &ContactConfig::skid_resistance, "ratio of masses")
      .def_readonly("skid_time", &ContactConfig::skid_time, "[s]")
      .def_readonly("gyration_radius", &ContactConfig::gyration_radius, "[m]")
      .def_readonly("release_gap", &ContactConfig::release_gap, "[m]")
      .def_readonly("release_time", &ContactConfig::release_time, "[s]")
      .def(py::pickle(
          [](const ContactConfig& k) {
            return py::make_tuple(k.friction, k.skid_resistance, k.skid_time, k.gyration_radius, k.release_gap,
                                  k.release_time);
          },
          [](const py::tuple& t) {
            return ContactConfig{t[0].cast<double>(), t[1].cast<double>(), t[2].cast<double>(),
                                 t[3].cast<double>(), t[4].cast<double>(), t[5].cast<double>()};
          }));
}

void bind_chair_config(py::module_& m) {
  const ChairConfig c;
  py::class_<ChairConfig>(
      m, "ChairConfig",
      "The simulated chair. linear_slip, angular_slip: share that the wheels turn too much, which the odometry "
      "believes; slip_sd: sd of a random share added to both, anew each control period; command_latency [s]: a command "
      "acts that long after it was given; sub_step [s]: the motors' own period. ValueError names a field out of range.")
      .def(py::init([](const Footprint& footprint, const MotionLimits& limits, const ContactConfig& contact,
                       double linear_slip, double angular_slip, double slip_sd, double command_latency,
                       double sub_step) {
             const ChairConfig made{footprint,    limits,  contact,         linear_slip,
                                    angular_slip, slip_sd, command_latency, sub_step};
             validate(made);
             return made;
           }),
           py::kw_only(), py::arg("footprint") = c.footprint, py::arg("limits") = c.limits,
           py::arg("contact") = c.contact, py::arg("linear_slip") = c.linear_slip,
           py::arg("angular_slip") = c.angular_slip, py::arg("slip_sd") = c.slip_sd,
           py::arg("command_latency") = c.command_latency, py::arg("sub_step") = c.sub_step)
      .def_property_readonly("footprint", [](const ChairConfig& k) { return k.footprint; })
      .def_property_readonly("limits", [](const ChairConfig& k) { return k.limits; })
      .def_property_readonly("contact", [](const ChairConfig& k) { return k.contact; })
      .def_readonly("linear_slip", &ChairConfig::linear_slip, "share of the distance")
      .def_readonly("angular_slip", &ChairConfig::angular_slip, "share of the angle")
      .def_readonly("slip_sd", &ChairConfig::slip_sd, "share")
      .def_readonly("command_latency", &ChairConfig::command_latency, "[s]")
      .def_readonly("sub_step", &ChairConfig::sub_step, "[s]")
      .def(py::pickle(
          [](const ChairConfig& k) {
            return py::make_tuple(k.footprint, k.limits, k.contact, k.linear_slip, k.angular_slip, k.slip_sd,
                                  k.command_latency, k.sub_step);
          },
          [](const py::tuple& t) {
            return ChairConfig{t[0].cast<Footprint>(), t[1].cast<MotionLimits>(), t[2].cast<ContactConfig>(),
                               t[3].cast<double>(),    t[4].cast<double>(),       t[5].cast<double>(),
                               t[6].cast<double>(),    t[7].cast<double>()};
          }));
}

void bind_lidar_config(py::module_& m) {
  const LidarConfig c;
  py::class_<LidarConfig>(
      m, "LidarConfig",
      "The simulated LIDAR: number of beams over field_of_view [rad] (first to last, symmetric about ahead), range_max "
      "and noise_sd [m], T_base_laser. Default: 181 beams over 180 degrees, 0.70 m before the axle (Sec. 3.2). "
      "ValueError names a field out of range.")
      .def(py::init([](int beams, double field_of_view, double range_max, double noise_sd, const Pose2& T_base_laser) {
             const LidarConfig made{beams, field_of_view, range_max, noise_sd, T_base_laser};
             validate(made);
             return made;
           }),
           py::kw_only(), py::arg("beams") = c.beams, py::arg("field_of_view") = c.field_of_view,
           py::arg("range_max") = c.range_max, py::arg("noise_sd") = c.noise_sd,
           py::arg("T_base_laser") = c.T_base_laser)
      .def_readonly("beams", &LidarConfig::beams)
      .def_readonly("field_of_view", &LidarConfig::field_of_view, "[rad]")
      .def_readonly("range_max", &LidarConfig::range_max, "[m]")
      .def_readonly("noise_sd", &LidarConfig::noise_sd, "[m]")
      .def_property_readonly("T_base_laser", [](const LidarConfig& k) { return k.T_base_laser; })
      .def(py::pickle(
          [](const LidarConfig& k) {
            return py::make_tuple(k.beams, k.field_of_view, k.range_max, k.noise_sd, k.T_base_laser);
          },
          [](const py::tuple& t) {
            return LidarConfig{t[0].cast<int>(), t[1].cast<double>(), t[2].cast<double>(), t[3].cast<double>(),
                               t[4].cast<Pose2>()};
          }));
}

void bind_step_result(py::module_& m) {
  py::class_<StepResult>(m, "StepResult", "What one control period led to.")
      .def_property_readonly(
          "pose", [](const StepResult& r) { return r.pose; }, "T_map_base, true")
      .def_property_readonly(
          "twist", [](const StepResult& r) { return r.twist; }, "of the wheels at the end, after any contact")
      .def_property_readonly(
          "odometry", [](const StepResult& r) { return r.odometry; }, "T_odom_base, as the encoders have it")
      .def_property_readonly(
          "odometry_twist", [](const StepResult& r) { return r.odometry_twist; }, "as the encoders have it")
      .def_readonly("in_contact", &StepResult::in_contact, "touching, or not yet clear of the last contact")
      .def_readonly("collision_started", &StepResult::collision_started, "a contact began in this period");
}

void bind_chair_state(py::module_& m) {
  py::class_<ChairState>(m, "ChairState", "The truth about the chair, for drivers and metrics, not for assistants.")
      .def_readonly("stamp", &ChairState::stamp, "since the reset [s]")
      .def_property_readonly(
          "pose", [](const ChairState& s) { return s.pose; }, "T_map_base")
      .def_property_readonly(
          "twist", [](const ChairState& s) { return s.twist; }, "of the wheels")
      .def_readonly("in_contact", &ChairState::in_contact, "touching, or not yet clear of the last contact")
      .def_readonly("collisions", &ChairState::collisions, "contacts begun since the reset")
      .def_readonly("distance", &ChairState::distance, "travelled by the axle's centre since the reset [m]")
      .def_property_readonly(
          "contact_point", [](const ChairState& s) { return s.contact_point; },
          "(2,) of the last collision: centre of the touched cell in the map [m]; NaN before one");
}

void bind_driving_world(py::module_& m) {
  py::class_<DrivingWorld>(
      m, "DrivingWorld",
      "A chair with odometry and a LIDAR, driven through a map in control periods. The chair stands nowhere until "
      "reset(). unknown_is_solid: unknown cells and all outside the map stop the chair and the LIDAR's beams alike "
      "(real "
      "buildings); else both pass. The same seed gives the same bytes; the noise of a period depends on the seed and "
      "the number of the period alone, whatever was driven, and scan noise and slip are separate streams.")
      .def(py::init<const OccupancyGrid&, const ChairConfig&, const LidarConfig&, std::uint64_t, bool>(),
           py::arg("grid"), py::arg("chair") = ChairConfig{}, py::arg("lidar") = LidarConfig{}, py::arg("seed") = 0,
           py::arg("unknown_is_solid") = true, without_gil())
      .def("reset", &DrivingWorld::reset, py::arg("pose"),
           "Puts the chair at rest at T_map_base, with odometry, counters, clock and noise as new. ValueError for a "
           "pose "
           "that is not finite or touches an obstacle, saying where.")
      .def("step", &DrivingWorld::step, py::arg("command"), py::arg("duration") = 0.1,
           "Drives towards the command (Twist2) for `duration` [s], at most 10 -> StepResult. A command beyond the "
           "limits is cut to them. Never ends touching an obstacle. ValueError for values that are not finite and "
           "before "
           "a reset.")
      .def("scan", py::overload_cast<>(&DrivingWorld::scan, py::const_), without_gil(),
           "What the LIDAR sees now -> LaserScan; asked twice in a period, the same.")
      .def_property_readonly("state", &DrivingWorld::state, "the truth now (ChairState, a copy)")
      .def_property_readonly("odometry", &DrivingWorld::odometry, "T_odom_base; starts at (0, 0, 0)")
      .def_property_readonly(
          "chair", [](const DrivingWorld& w) { return w.chair(); }, "its ChairConfig")
      .def_property_readonly(
          "lidar", [](const DrivingWorld& w) { return w.lidar(); }, "its LidarConfig")
      .def("touches", &DrivingWorld::touches, py::arg("pose"), py::arg("margin") = 0.0,
           "True if the footprint, grown by a margin [m], of a chair at T_map_base touches a solid cell.");
}

}  // namespace

void bind_simulation(py::module_& m) {
  bind_contact_config(m);
  bind_chair_config(m);
  bind_lidar_config(m);
  bind_step_result(m);
  bind_chair_state(m);
  bind_driving_world(m);
  m.def(
      "joystick_to_twist", &joystick_to_twist, py::arg("forward"), py::arg("left"), py::arg("limits") = MotionLimits{},
      "The Twist2 that a joystick asks for: forward in [-1, 1] scales max_linear (max_reverse when negative), left in "
      "[-1, 1] scales max_angular. ValueError for values out of [-1, 1] or NaN.");
}

}  // namespace lfdcore
