#include <limits>
#include <memory>

#include "common.hpp"
#include "fields.hpp"
#include "lfdcore/hardware/encoder_odometry.hpp"
#include "lfdcore/hardware/joystick_link.hpp"

namespace lfdcore {
namespace {

using joystick::Calibration;

using AxisEnds = std::array<std::uint16_t, 4>;
using OutputEnds = std::array<std::uint16_t, 3>;

const char* name_of(joystick::State state) {
  static const char* const names[] = {"neutral_required", "ready", "driving", "fault", "emergency", "disconnected"};
  return names[static_cast<int>(state)];
}

std::vector<std::string> names_of(std::uint16_t faults) {
  static const std::pair<joystick::Fault, const char*> names[] = {
      {joystick::not_calibrated, "not calibrated"}, {joystick::forward_wire, "forward wire"},
      {joystick::left_wire, "left wire"},           {joystick::dac_failed, "DAC"},
      {joystick::bad_command, "bad command"},       {joystick::forward_memory, "forward DAC's memory"},
      {joystick::left_memory, "left DAC's memory"}};
  std::vector<std::string> found;
  for (const auto& [bit, name] : names) {
    if (faults & bit) found.emplace_back(name);
    faults = static_cast<std::uint16_t>(faults & ~bit);
  }
  if (faults != 0) found.emplace_back("unknown");
  return found;
}

template <typename Small>
Small small(const char* name, long value) {
  require_between(name, value, 0, std::numeric_limits<Small>::max(), "");
  return static_cast<Small>(value);
}

Calibration calibration_of(const std::array<std::array<long, 4>, 2>& axes,
                           const std::array<std::array<long, 3>, 2>& outputs, const std::array<long, 4>& profiles) {
  Calibration made{};
  const auto counts = [](long value) { return small<std::uint16_t>("a count or code of the calibration", value); };
  for (int i = 0; i < 2; ++i) {
    made.axis[i] = {counts(axes[i][0]), counts(axes[i][1]), counts(axes[i][2]), counts(axes[i][3])};
    made.output[i] = {counts(outputs[i][0]), counts(outputs[i][1]), counts(outputs[i][2])};
  }
  for (int i = 0; i < 4; ++i) made.profile_percent[i] = small<std::uint8_t>("a profile's percent", profiles[i]);
  require(joystick::is_sound(made), joystick::sound_calibration);
  return made;
}

std::array<AxisEnds, 2> axes_of(const Calibration& calibration) {
  std::array<AxisEnds, 2> ends{};
  for (int i = 0; i < 2; ++i) {
    const auto& axis = calibration.axis[i];
    ends[i] = {axis.minus, axis.centre, axis.plus, axis.dead_zone};
  }
  return ends;
}

std::array<OutputEnds, 2> outputs_of(const Calibration& calibration) {
  std::array<OutputEnds, 2> ends{};
  for (int i = 0; i < 2; ++i) {
    const auto& output = calibration.output[i];
    ends[i] = {output.minus, output.neutral, output.plus};
  }
  return ends;
}

void bind_calibration(py::module_& m) {
  py::class_<Calibration>(m, "JoystickCalibration",
                          "What a joystick's voltages mean, and what voltages the chair's controller takes "
                          "(docs/joystick-link.md).")
      .def(py::init(&calibration_of), py::kw_only(), py::arg("axes"), py::arg("outputs"), py::arg("profiles"),
           "axes: of forward and left, each (minus, centre, plus, dead zone) [ADC counts, 0 to 1023]; outputs: of "
           "forward and left, each (minus, neutral, plus) [DAC codes, 0 to 4095]; profiles: 4, each 1 to 100 [%]. "
           "ValueError for what is not sound.")
      .def_property_readonly("axes", &axes_of, "of forward and left: (minus, centre, plus, dead zone) [ADC counts]")
      .def_property_readonly("outputs", &outputs_of, "of forward and left: (minus, neutral, plus) [DAC codes]")
      .def_property_readonly(
          "profiles",
          [](const Calibration& calibration) {
            std::array<std::uint8_t, 4> percent{};
            std::copy(calibration.profile_percent, calibration.profile_percent + 4, percent.begin());
            return percent;
          },
          "[%] of full output that each profile gives");
}

void bind_reading(py::module_& m) {
  py::class_<JoystickReading>(m, "JoystickReading", "What the newest report of the joystick's chip says.")
      .def_readonly("stamp", &JoystickReading::stamp, "[s] of time.monotonic(), when the stick was read")
      .def_readonly("tick", &JoystickReading::tick, "[ms] of the chip's clock, the same; it wraps around at 32 bits")
      .def_readonly("run", &JoystickReading::run,
                    "how often the chip began anew, as far as can be told: edges of two runs do not compare")
      .def_readonly("forward", &JoystickReading::forward, "of the stick, in [-1, 1]")
      .def_readonly("left", &JoystickReading::left, "of the stick, in [-1, 1]")
      .def_readonly("adc", &JoystickReading::adc, "of both axes [counts]")
      .def_readonly("edges", &JoystickReading::edges, "of the left and the right encoder; they wrap around at 32 bits")
      .def_readonly("lost_edges", &JoystickReading::lost_edges, "that came too fast, since power-up; wraps around")
      .def_readonly("given_forward", &JoystickReading::given_forward, "what the controller is given, in [-1, 1]")
      .def_readonly("given_left", &JoystickReading::given_left, "what the controller is given, in [-1, 1]")
      .def_property_readonly(
          "chip", [](const JoystickReading& said) { return name_of(said.chip); }, "the chip's state")
      .def_property_readonly(
          "faults", [](const JoystickReading& said) { return names_of(said.faults); }, "by name")
      .def_readonly("manual", &JoystickReading::manual, "the manual button is pressed")
      .def_readonly("emergency", &JoystickReading::emergency, "the emergency input is")
      .def_readonly("profile", &JoystickReading::profile, "selected, 0 to 3");
  py::class_<LinkStatistics>(m, "LinkStatistics", "Counted since the link began.")
      .def_readonly("reports", &LinkStatistics::reports)
      .def_readonly("lost_reports", &LinkStatistics::lost_reports, "gaps in what the chip counts")
      .def_readonly("bad_frames", &LinkStatistics::bad_frames, "that came in and were none")
      .def_readonly("answers", &LinkStatistics::answers)
      .def_readonly("connections", &LinkStatistics::connections,
                    "begun with a report after there was none, or of a chip that began anew");
  py::class_<JoystickIdentity>(m, "JoystickIdentity", "Who the chip is.")
      .def_readonly("firmware", &JoystickIdentity::firmware, "version")
      .def_readonly("calibrated", &JoystickIdentity::calibrated)
      .def_readonly("calibration", &JoystickIdentity::calibration, "what is stored; of no meaning if not calibrated");
}

// Ctrl-C ends the waiting.
std::unique_ptr<JoystickLink> open_link(const std::string& port, double patience) {
  const py::gil_scoped_release release;
  return std::make_unique<JoystickLink>(port, patience, [] {
    const py::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  });
}

void bind_link(py::module_& m) {
  py::class_<JoystickLink>(
      m, "JoystickLink",
      "The link to the Arduino at the joystick (docs/joystick-link.md). A thread answers each of its reports with the "
      "newest command, as far as the stick allows it. A cable that is pulled out is a state; the thread finds it "
      "again.")
      .def(py::init(&open_link), py::arg("port"), py::arg("patience") = 3.0,
           "Opens a serial port and waits for the first report, `patience` [s] at the longest, 60 at most. DeviceError "
           "for a port that cannot be opened, and for one at which nothing, or something else, talks.")
      .def("read", &JoystickLink::read, without_gil(), "-> what the newest report says; None while there is none")
      .def("take_readings", &JoystickLink::take_readings, without_gil(),
           "-> all readings since this was called last, the oldest first: of the last 2 s at most")
      .def("command", &JoystickLink::command, py::arg("forward"), py::arg("left"),
           py::arg("duration") = JoystickSession::expiry, without_gil(),
           "What the chair is to do from now on, each in [-1, 1] of full output, for `duration` [s], .25 at the "
           "longest. "
           "What is not finite or out of range is no error but the state fault, which ends at neutral after a sound "
           "command.")
      .def_property_readonly(
          "state", [](const JoystickLink& link) { return name_of(link.state()); },
          "'neutral_required', 'ready', 'driving', 'fault', 'emergency' or 'disconnected'")
      .def_property_readonly("fault", &JoystickLink::fault, "why there is no link; empty while there is one")
      .def_property_readonly("statistics", &JoystickLink::statistics)
      .def_property_readonly("port", &JoystickLink::port)
      .def("identity", &JoystickLink::identity, without_gil(), "Asks who the chip is. DeviceError without an answer.")
      .def("calibrate", &JoystickLink::calibrate, py::arg("calibration"), without_gil(),
           "Stores a calibration in the chip. DeviceError where it does not take it: it drives, or does not answer.")
      .def(
          "select_profile",
          [](JoystickLink& link, long profile) { link.select_profile(small<std::uint8_t>("profile", profile)); },
          py::arg("profile"), without_gil(), "0 to 3; the stick is needed at neutral then. ValueError for another.")
      .def("close", &JoystickLink::close, without_gil(), "Ends the thread and lets the port go.");
}

void bind_odometry(py::module_& m) {
  using Config = WheelEncoders;
  bind_settings(m, "WheelEncoders", "Wheels and their encoders. Nothing has a default that could be another chair's.",
                Field("left_radius", &Config::left_radius, "[m]"), Field("right_radius", &Config::right_radius, "[m]"),
                Field("track", &Config::track, "[m] between the wheels"),
                Field("edges_per_turn", &Config::edges_per_turn,
                      "of a wheel: four a line of a quadrature encoder; negative where it counts back"),
                Field("window", &Config::window, "[s] over which the twist is the mean"));
  py::class_<EncoderOdometry>(m, "EncoderOdometry", "Adds up what two wheels' encoders count; counts wrap around.")
      .def(py::init<const Config&>(), py::arg("config"), "ValueError names a field that is out of range.")
      .def("update", &EncoderOdometry::update, py::arg("stamp"), py::arg("left"), py::arg("right"),
           "Takes counts read at `stamp` [s]; those of a stamp that is not later are not taken.")
      .def("reset", &EncoderOdometry::reset, "The next counts begin anew; the pose stays.")
      .def_property_readonly(
          "pose", [](const EncoderOdometry& odometry) { return Pose2(odometry.pose()); }, "T_odom_base")
      .def_property_readonly(
          "twist", [](const EncoderOdometry& odometry) { return Twist2(odometry.twist()); },
          "[m/s, rad/s], the mean of the last window");
}

}  // namespace

void bind_joystick(py::module_& m) {
  bind_calibration(m);
  bind_reading(m);
  bind_link(m);
  bind_odometry(m);
}

}  // namespace lfdcore
