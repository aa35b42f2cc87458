#include "common.hpp"
#include "fields.hpp"
#include "lfdcore/simulation/driving_world.hpp"

namespace lfdcore {
namespace {

void bind_contact_config(py::module_& m) {
  bind_settings(
      m, "ContactConfig",
      "How the body behaves where it touches: friction (Coulomb's coefficient), skid_resistance (how much harder than "
      "rolling it is to push the wheels sideways, a ratio of masses), skid_time [s] in which they grip again, "
      "gyration_radius [m]; a contact lasts until the body has been clear of everything by release_gap [m] for "
      "release_time [s], so that chattering counts once.",
      Field("friction", &ContactConfig::friction, "Coulomb's coefficient"),
      Field("skid_resistance", &ContactConfig::skid_resistance, "ratio of masses"),
      Field("skid_time", &ContactConfig::skid_time, "[s]"),
      Field("gyration_radius", &ContactConfig::gyration_radius, "[m]"),
      Field("release_gap", &ContactConfig::release_gap, "[m]"),
      Field("release_time", &ContactConfig::release_time, "[s]"));
}

void bind_chair_config(py::module_& m) {
  bind_settings(
      m, "ChairConfig",
      "The simulated chair. linear_slip, angular_slip: share that the wheels turn too much, which the odometry "
      "believes; slip_sd: sd of a random share added to both, anew each control period; command_latency [s]: a command "
      "acts that long after it was given; sub_step [s]: the motors' own period. ValueError names a field out of range.",
      Field("footprint", &ChairConfig::footprint), Field("limits", &ChairConfig::limits),
      Field("contact", &ChairConfig::contact), Field("linear_slip", &ChairConfig::linear_slip, "share of the distance"),
      Field("angular_slip", &ChairConfig::angular_slip, "share of the angle"),
      Field("slip_sd", &ChairConfig::slip_sd, "share"), Field("command_latency", &ChairConfig::command_latency, "[s]"),
      Field("sub_step", &ChairConfig::sub_step, "[s]"));
}

void bind_lidar_config(py::module_& m) {
  bind_settings(
      m, "LidarConfig",
      "The simulated LIDAR: number of beams over field_of_view [rad] (first to last, symmetric about ahead), range_max "
      "and noise_sd [m], T_base_laser. Default: 181 beams over 180 degrees, 0.70 m before the axle (Sec. 3.2). "
      "ValueError names a field out of range.",
      Field("beams", &LidarConfig::beams), Field("field_of_view", &LidarConfig::field_of_view, "[rad]"),
      Field("range_max", &LidarConfig::range_max, "[m]"), Field("noise_sd", &LidarConfig::noise_sd, "[m]"),
      Field("T_base_laser", &LidarConfig::T_base_laser));
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
  py::class_<ChairState>(m, "ChairState",
                         "The truth about the chair, for drivers and metrics, not for assistants. Its contacts are "
                         "those with the map.")
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

void bind_person(py::module_& m) {
  bind_settings(
      m, "Person",
      "A whole person at the scanner's height as one disc: body, both legs and the room of a stride. Walks on at its "
      "velocity. ValueError names a field out of range: position within 1e6 m, at most 10 m/s along each axis, "
      "0 < radius <= 5 m.",
      Field("position", &Person::position, "(2,) of the centre in map [m]"),
      Field("velocity", &Person::velocity, "(2,) [m/s]"), Field("radius", &Person::radius, "[m]"));
}

const char* name_of(OutlinePart part) {
  constexpr std::array names{"nose", "left", "right", "rear"};
  return names[static_cast<std::size_t>(part)];
}

void bind_person_contact(py::module_& m) {
  py::class_<PersonContact>(m, "PersonContact",
                            "What was so when a contact of the chair with a person began: the first of the motors' "
                            "periods at whose end disc and outline share a point.")
      .def_readonly("person", &PersonContact::person, "its place among the people")
      .def_readonly("stamp", &PersonContact::stamp, "since the reset [s]")
      .def_property_readonly(
          "pose", [](const PersonContact& c) { return c.pose; }, "of the chair, T_map_base")
      .def_property_readonly(
          "twist", [](const PersonContact& c) { return c.twist; }, "of its wheels")
      .def_property_readonly(
          "position", [](const PersonContact& c) { return c.position; }, "(2,) of the person in map [m]")
      .def_property_readonly(
          "velocity", [](const PersonContact& c) { return c.velocity; }, "(2,) of the person in map [m/s]")
      .def_property_readonly(
          "point", [](const PersonContact& c) { return c.point; },
          "(2,) of the outline that is nearest to the person's centre, in base_link [m]")
      .def_property_readonly(
          "part", [](const PersonContact& c) { return name_of(c.part); },
          "where that is: 'nose', 'left', 'right' or 'rear'; a corner belongs to the nose or the rear")
      .def_readonly("chair_approach", &PersonContact::chair_approach,
                    "speed of the outline at that point towards the person [m/s]")
      .def_readonly("person_approach", &PersonContact::person_approach,
                    "the person's speed towards the outline there [m/s]")
      .def_readonly("chair_approach_since", &PersonContact::chair_approach_since,
                    "the largest chair_approach while they touched, until the person's centre was inside [m/s]");
}

void bind_driving_world(py::module_& m) {
  py::class_<DrivingWorld>(
      m, "DrivingWorld",
      "A chair with odometry and a LIDAR, driven through a map among people in control periods. The chair stands "
      "nowhere until "
      "reset(). unknown_is_solid: unknown cells and all outside the map stop the chair and the LIDAR's beams alike "
      "(real buildings); else both pass. The same seed gives the same bytes; the noise of a period depends on the seed "
      "and the number of the period alone, whatever was driven, and scan noise and slip are separate streams.")
      .def(py::init<const OccupancyGrid&, const ChairConfig&, const LidarConfig&, std::uint64_t, bool>(),
           py::arg("grid"), py::arg("chair") = ChairConfig{}, py::arg("lidar") = LidarConfig{}, py::arg("seed") = 0,
           py::arg("unknown_is_solid") = true, without_gil())
      .def("reset", &DrivingWorld::reset, py::arg("pose"),
           "Puts the chair at rest at T_map_base, with odometry, counters, clock and noise as new. ValueError for a "
           "pose that is not finite or touches an obstacle, saying where.")
      .def("step", &DrivingWorld::step, py::arg("command"), py::arg("duration") = 0.1,
           "Drives towards the command (Twist2) for `duration` [s], at most 10 -> StepResult. A command beyond the "
           "limits is cut to them. Never ends touching an obstacle. ValueError for values that are not finite and "
           "before a reset.")
      .def("scan", py::overload_cast<>(&DrivingWorld::scan, py::const_), without_gil(),
           "What the LIDAR sees now -> LaserScan; asked twice in a period, the same.")
      .def("set_people", &DrivingWorld::set_people, py::arg("people"),
           "The people (list of Person) from now on, each known by its place in the list: a contact goes on from one "
           "list to the next. In step each walks straight on at its velocity, through whatever is there: they are no "
           "walls, neither the chair nor they are stopped or pushed where they meet, which is counted "
           "(person_contacts). Without people everything is as in a world that never had any, byte by byte. "
           "ValueError before a reset, which takes all people away.")
      .def_property_readonly("people", &DrivingWorld::people, "where they are now: list of Person, copies")
      .def_property_readonly("person_contacts", &DrivingWorld::person_contacts,
                             "list of PersonContact since the reset, in the order in which they began")
      .def_property_readonly("touches_person", &DrivingWorld::touches_person,
                             "whether a contact with a person is not yet over: until it has been clear by "
                             "ContactConfig.release_gap for release_time")
      .def("people_in_scan", &DrivingWorld::people_in_scan, without_gil(),
           "For each person whether a beam of the LIDAR, without noise, meets it first -> list of bool.")
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
  bind_person(m);
  bind_person_contact(m);
  bind_driving_world(m);
  m.def(
      "joystick_to_twist", &joystick_to_twist, py::arg("forward"), py::arg("left"), py::arg("limits") = MotionLimits{},
      "The Twist2 that a joystick asks for: forward in [-1, 1] scales max_linear (max_reverse when negative), left in "
      "[-1, 1] scales max_angular. ValueError for values out of [-1, 1] or NaN.");
}

}  // namespace lfdcore
