#include "lfdcore/simulation/differential_drive.hpp"

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

void validate_body(const Footprint& footprint) {
  require_between("footprint.front", footprint.front, 0.01, 10, "m");
  require_between("footprint.rear", footprint.rear, 0.01, 10, "m");
  require_between("footprint.half_width", footprint.half_width, 0.01, 10, "m");
}

// Faster, a sub-step would be too long to find a contact in.
void validate_speeds(const MotionLimits& limits) {
  validate(limits);
  require_between("limits.max_linear", limits.max_linear, 0, 20, "m/s");
  require_between("limits.max_reverse", limits.max_reverse, 0, 20, "m/s");
  require_between("limits.max_angular", limits.max_angular, 0, 20, "rad/s");
}

}  // namespace

void validate(const ContactConfig& contact) {
  require_between("friction", contact.friction, 0, 10, "");
  require_between("skid_resistance", contact.skid_resistance, 0.01, 1e4, "");
  require_between("skid_time", contact.skid_time, 0.001, 10, "s");
  require_between("gyration_radius", contact.gyration_radius, 0.01, 10, "m");
  require_between("release_gap", contact.release_gap, 0, 1, "m");
  require_between("release_time", contact.release_time, 0, 60, "s");
}

void validate(const ChairConfig& chair) {
  validate_body(chair.footprint);
  validate_speeds(chair.limits);
  validate(chair.contact);
  require_between("linear_slip", chair.linear_slip, -0.5, 0.5, "");
  require_between("angular_slip", chair.angular_slip, -0.5, 0.5, "");
  require_between("slip_sd", chair.slip_sd, 0, 0.5, "");
  require_between("command_latency", chair.command_latency, 0, 10, "s");
  require_between("sub_step", chair.sub_step, 1e-4, 0.1, "s");
}

Twist2 joystick_to_twist(double forward, double left, const MotionLimits& limits) {
  require_between("forward", forward, -1, 1, "of full stick");
  require_between("left", left, -1, 1, "of full stick");
  return {forward * (forward < 0 ? limits.max_reverse : limits.max_linear), left * limits.max_angular};
}

}  // namespace lfdcore
