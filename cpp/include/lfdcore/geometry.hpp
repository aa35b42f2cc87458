// Planar poses, twists and the chair's outline. SI units, radians, REP-103 axes (x forward, y left, yaw anticlockwise).
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

namespace lfdcore {

inline constexpr double pi = 3.14159265358979323846;

/// The same angle in (-pi, pi].
inline double wrap_angle(double angle) {
  const double wrapped = std::remainder(angle, 2 * pi);
  return wrapped <= -pi ? pi : wrapped;
}

/// A position [m] and heading [rad] in the plane. T_a_b maps coordinates of frame b into frame a.
struct Pose2 {
  double x = 0, y = 0, yaw = 0;

  /// T_a_c = T_a_b * T_b_c
  Pose2 operator*(const Pose2& next) const {
    const double c = std::cos(yaw), s = std::sin(yaw);
    return {x + c * next.x - s * next.y, y + s * next.x + c * next.y, wrap_angle(yaw + next.yaw)};
  }

  /// A point of frame b in frame a.
  Eigen::Vector2d operator*(const Eigen::Vector2d& point) const {
    const double c = std::cos(yaw), s = std::sin(yaw);
    return {x + c * point.x() - s * point.y(), y + s * point.x() + c * point.y()};
  }

  /// T_b_a
  Pose2 inverse() const {
    const double c = std::cos(yaw), s = std::sin(yaw);
    return {-(c * x + s * y), -(-s * x + c * y), wrap_angle(-yaw)};
  }
};

/// Velocity of a differential drive: along its heading [m/s] and anticlockwise [rad/s].
struct Twist2 {
  double linear = 0, angular = 0;
};

/// The pose after following a constant twist for some time [s], exactly (a circular arc).
Pose2 integrate(const Pose2& pose, const Twist2& twist, double duration);

/// A rectangle around the axle's centre: it reaches `front` ahead, `rear` behind and `half_width` to each side [m].
/// Defaults: the CAS chair, 0.8 m from axle to front edge and 0.7 m wide (Sec. 3.2).
struct Footprint {
  double front = 0.80, rear = 0.35, half_width = 0.35;

  /// The rectangle grown by a margin [m] on every side.
  Footprint grown(double margin) const { return {front + margin, rear + margin, half_width + margin}; }
  /// Radius [m] of the smallest circle around the axle that holds the rectangle.
  double outer_radius() const { return std::hypot(std::max(front, rear), half_width); }
  /// Corners (4, 2) [m] in base_link, anticlockwise from the front left.
  std::array<Eigen::Vector2d, 4> corners() const {
    return {{{front, half_width}, {-rear, half_width}, {-rear, -half_width}, {front, -half_width}}};
  }
};

/// Throws std::invalid_argument for a side that is not finite or reaches beyond 100 m: no search around it would end.
void require_bounded(const Footprint& footprint);

}  // namespace lfdcore
