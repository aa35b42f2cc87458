#include "lfdcore/motion.hpp"

#include <algorithm>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

double towards(double from, double to, double step) { return from + std::clamp(to - from, -step, step); }

// Braking first, then speeding up the other way with what is left of the time.
double approach_linear(double current, double wanted, const MotionLimits& limits, double duration) {
  const bool slowing = current * wanted < 0 || std::abs(wanted) < std::abs(current);
  if (!slowing) return towards(current, wanted, limits.linear_acceleration * duration);
  const double floor = current * wanted < 0 ? 0.0 : wanted;
  const double needed = std::abs(current - floor) / limits.linear_braking;
  if (needed >= duration) return towards(current, floor, limits.linear_braking * duration);
  return towards(floor, wanted, limits.linear_acceleration * (duration - needed));
}

}  // namespace

void validate(const MotionLimits& limits) {
  require_positive("max_linear", limits.max_linear, "m/s");
  require_positive("max_reverse", limits.max_reverse, "m/s");
  require_positive("max_angular", limits.max_angular, "rad/s");
  require_positive("linear_acceleration", limits.linear_acceleration, "m/s^2");
  require_positive("linear_braking", limits.linear_braking, "m/s^2");
  require_positive("angular_acceleration", limits.angular_acceleration, "rad/s^2");
}

Twist2 approach(const Twist2& current, const Twist2& wanted, const MotionLimits& limits, double duration) {
  const double linear = std::clamp(wanted.linear, -limits.max_reverse, limits.max_linear);
  const double angular = std::clamp(wanted.angular, -limits.max_angular, limits.max_angular);
  return {approach_linear(current.linear, linear, limits, duration),
          towards(current.angular, angular, limits.angular_acceleration * duration)};
}

}  // namespace lfdcore
