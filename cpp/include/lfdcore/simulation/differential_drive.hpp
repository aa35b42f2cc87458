// The chair as a machine: what its joystick asks for, how its motors follow, how it behaves against a wall.
#pragma once

#include "lfdcore/geometry.hpp"
#include "lfdcore/motion.hpp"

namespace lfdcore {

/// How the body behaves where it touches (docs/decisions: the thesis's simulator had no side contact, Sec. 3.6).
struct ContactConfig {
  double friction = 0.3;         ///< Coulomb's coefficient between body and wall
  double skid_resistance = 2.0;  ///< how much harder than rolling it is to push the wheels sideways (ratio of masses)
  double skid_time = 0.2;        ///< in which wheels that were pushed sideways grip again (time constant) [s]
  double gyration_radius = 0.4;  ///< of chair and driver about the axle's centre [m]
  double release_gap = 0.02;     ///< a contact lasts until the body is clear of everything by this much [m] ...
  double release_time = 0.5;     ///< ... for this long [s], so that chattering counts once
};

struct ChairConfig {
  Footprint footprint;
  MotionLimits limits;
  ContactConfig contact;
  double linear_slip = 0.0;      ///< share of the distance that the wheels turn too much; the odometry believes it
  double angular_slip = 0.0;     ///< the same of the angle turned
  double slip_sd = 0.0;          ///< sd of a random share added to both, drawn anew each control period
  double command_latency = 0.0;  ///< a command acts this long after it was given [s]
  double sub_step = 0.02;        ///< the motors' own period [s]
};

/// Throws std::invalid_argument, naming the field, for a value that is not finite or out of its range.
void validate(const ContactConfig& contact);
void validate(const ChairConfig& chair);

/// The twist that a joystick asks for: `forward` in [-1, 1] scales max_linear (max_reverse when negative), `left` in
/// [-1, 1] scales max_angular, positive to the left (F12). Throws std::invalid_argument for values out of [-1, 1] or
/// NaN.
Twist2 joystick_to_twist(double forward, double left, const MotionLimits& limits);

}  // namespace lfdcore
