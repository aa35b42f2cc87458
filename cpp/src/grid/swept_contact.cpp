#include "lfdcore/grid/swept_contact.hpp"

namespace lfdcore {
namespace {

struct Motion {
  const ObstaclePoints& obstacles;
  const Footprint& footprint;
  const Pose2& pose;
  const Twist2& twist;
};

std::optional<double> bisect(const Motion& motion, double from, double to) {
  const double duration = to - from;
  const Footprint held = swept(motion.footprint, motion.twist.linear * duration, motion.twist.angular * duration);
  const Pose2 middle = integrate(motion.pose, motion.twist, from + duration / 2);
  if (!motion.obstacles.collides(middle, held)) return std::nullopt;
  const double growth = std::max(held.front - motion.footprint.front, held.half_width - motion.footprint.half_width);
  if (growth <= sweep_tolerance) return from;
  if (const auto early = bisect(motion, from, from + duration / 2)) return early;
  return bisect(motion, from + duration / 2, to);
}

}  // namespace

Footprint swept(const Footprint& footprint, double distance, double turn) {
  const double ahead = std::abs(distance) / 2, angle = std::abs(turn) / 2;
  const double along = ahead + angle * footprint.half_width;
  const double across = angle * std::max(footprint.front, footprint.rear) + ahead * angle / 2;
  return {footprint.front + along, footprint.rear + along, footprint.half_width + across};
}

std::optional<double> first_contact(const ObstaclePoints& obstacles, const Footprint& footprint, const Pose2& pose,
                                    const Twist2& twist, double duration) {
  return bisect({obstacles, footprint, pose, twist}, 0.0, duration);
}

}  // namespace lfdcore
