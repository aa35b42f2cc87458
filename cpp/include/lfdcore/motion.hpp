// What a differential drive can do: speed and acceleration limits.
#pragma once

#include "lfdcore/geometry.hpp"

namespace lfdcore {

/// Limits of the chair. Speeds: 1 m/s and 1 rad/s at full stick; the thesis states none (docs/decisions).
struct MotionLimits {
  double max_linear = 1.0;            ///< ahead [m/s]
  double max_reverse = 0.4;           ///< backwards [m/s], positive
  double max_angular = 1.0;           ///< [rad/s]
  double linear_acceleration = 0.8;   ///< speeding up [m/s^2]
  double linear_braking = 1.5;        ///< slowing down [m/s^2]
  double angular_acceleration = 2.5;  ///< either way [rad/s^2]
};

/// Throws std::invalid_argument, naming the field, unless every limit is positive and finite.
void validate(const MotionLimits& limits);

/// The twist after `duration` [s] of changing `current` towards `wanted` as fast as the limits allow.
/// `wanted` beyond the speed limits is cut to them.
Twist2 approach(const Twist2& current, const Twist2& wanted, const MotionLimits& limits, double duration);

}  // namespace lfdcore
