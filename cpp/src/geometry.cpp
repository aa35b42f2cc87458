#include "lfdcore/geometry.hpp"

#include "lfdcore/error.hpp"

namespace lfdcore {

Pose2 integrate(const Pose2& pose, const Twist2& twist, double duration) {
  const double turn = twist.angular * duration;
  const double distance = twist.linear * duration;
  // The chord of the arc: its length by sin(h)/h, its direction half the turn.
  const double half = turn / 2;
  const double chord = std::abs(half) < 1e-6 ? distance * (1 - half * half / 6) : distance * std::sin(half) / half;
  return {pose.x + chord * std::cos(pose.yaw + half), pose.y + chord * std::sin(pose.yaw + half),
          wrap_angle(pose.yaw + turn)};
}

void require_bounded(const Footprint& footprint) {
  constexpr double longest = 100;
  require_between("footprint.front", footprint.front, -longest, longest, "m");
  require_between("footprint.rear", footprint.rear, -longest, longest, "m");
  require_between("footprint.half_width", footprint.half_width, -longest, longest, "m");
}

}  // namespace lfdcore
