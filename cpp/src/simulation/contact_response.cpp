#include "lfdcore/simulation/contact_response.hpp"

#include <Eigen/Geometry>

namespace lfdcore {
namespace {

/// A small displacement in the body's frame: ahead and sideways [m], anticlockwise [rad].
struct Shift {
  double ahead = 0, sideways = 0, turn = 0;

  Shift operator*(double factor) const { return {ahead * factor, sideways * factor, turn * factor}; }
};

/// Along an arc, and sideways evenly on the way.
Pose2 shifted(const Pose2& pose, const Shift& shift) {
  const Pose2 end = integrate(pose, {shift.ahead, shift.turn}, 1.0);
  const double middle = pose.yaw + shift.turn / 2;
  return {end.x - shift.sideways * std::sin(middle), end.y + shift.sideways * std::cos(middle), end.yaw};
}

/// The directions at right angles to a displacement, in coordinates where length is the root of kinetic energy.
struct Cone {
  Eigen::Vector3d axis, without_skid, with_skid;

  explicit Cone(const Eigen::Vector3d& driven) : axis(driven) {
    const Eigen::Vector3d level(-driven.z(), 0, driven.x());  // ahead and turn
    without_skid =
        level.norm() > 0 ? Eigen::Vector3d(level.normalized() * driven.norm()) : Eigen::Vector3d(driven.norm(), 0, 0);
    with_skid = driven.normalized().cross(without_skid);
  }
};

class Body {
 public:
  Body(const SolidMap& map, const ChairConfig& chair)
      : map_(map), chair_(chair), scale_(1, std::sqrt(chair.contact.skid_resistance), chair.contact.gyration_radius) {}

  BodyMotion move(const Pose2& pose, const BodyVelocity& velocity, double duration) const;

 private:
  bool free(const Pose2& pose, const Shift& shift) const;
  double free_share(const Pose2& pose, const Shift& shift) const;
  Shift on_cone(const Cone& cone, double away, double around) const;
  Shift slide(const Pose2& pose, const Shift& driven) const;
  Shift refined(const Pose2& pose, const Cone& cone, double blocked, double clear, double around) const;

  const SolidMap& map_;
  const ChairConfig& chair_;
  Eigen::Array3d scale_;  // roots of the masses that resist: ahead, sideways, turn
};

/// Checked at poses so near to each other that no corner moves by more than half a cell (or 5 cm) between them.
bool Body::free(const Pose2& pose, const Shift& shift) const {
  const double travel =
      std::hypot(shift.ahead, shift.sideways) + std::abs(shift.turn) * chair_.footprint.outer_radius();
  const double apart = std::min(0.5 * map_.grid().geometry.resolution, 0.05);
  const int pieces = std::max(1, static_cast<int>(std::ceil(travel / apart)));
  for (int i = pieces; i >= 1; --i)
    if (map_.touches(shifted(pose, shift * (static_cast<double>(i) / pieces)), chair_.footprint)) return false;
  return true;
}

/// The largest free part of a blocked displacement, by bisection to a thousandth.
double Body::free_share(const Pose2& pose, const Shift& shift) const {
  double low = 0, high = 1;
  for (int i = 0; i < 10; ++i) {
    const double middle = (low + high) / 2;
    (free(pose, shift * middle) ? low : high) = middle;
  }
  return low;
}

/// The displacement at an angle `away` from the driven one, to the side `around`. Its length is the driven one's
/// projection, shortened by friction: cos(away) - friction * sin(away).
Shift Body::on_cone(const Cone& cone, double away, double around) const {
  const double along = std::cos(away), across = std::sin(away);
  const Eigen::Array3d moved =
      (along * cone.axis + across * std::cos(around) * cone.without_skid + across * std::sin(around) * cone.with_skid) *
      (along - chair_.contact.friction * across);
  return {moved[0] / scale_[0], moved[1] / scale_[1], moved[2] / scale_[2]};
}

/// Between an angle that is blocked and one that is clear, nearly the smallest that is clear.
Shift Body::refined(const Pose2& pose, const Cone& cone, double blocked, double clear, double around) const {
  for (int i = 0; i < 4; ++i) {
    const double middle = (blocked + clear) / 2;
    (free(pose, on_cone(cone, middle, around)) ? clear : blocked) = middle;
  }
  return on_cone(cone, clear, around);
}

/// Cones around the driven displacement, wider and wider, until one holds a free displacement; none if friction holds.
Shift Body::slide(const Pose2& pose, const Shift& driven) const {
  constexpr double width = pi / 20;
  constexpr int rays = 16;
  // Without skid first, then little by little to either side.
  constexpr std::array<int, rays> order{0, 8, 1, 15, 7, 9, 2, 14, 6, 10, 3, 13, 5, 11, 4, 12};
  const Cone cone(Eigen::Array3d(driven.ahead, driven.sideways, driven.turn) * scale_);
  const double sticking = std::atan2(1.0, chair_.contact.friction);
  for (double away = width; away < sticking; away += width)
    for (const int ray : order)
      if (const double around = ray * 2 * pi / rays; free(pose, on_cone(cone, away, around)))
        return refined(pose, cone, away - width, away, around);
  return {};
}

BodyMotion Body::move(const Pose2& pose, const BodyVelocity& velocity, double duration) const {
  const Shift driven = Shift{velocity.twist.linear, velocity.skid, velocity.twist.angular} * duration;
  if (free(pose, driven))
    return {shifted(pose, driven), velocity, std::hypot(driven.ahead, driven.sideways), false, {}};
  const double share = free_share(pose, driven);
  const Pose2 touching = shifted(pose, driven * share);
  const Shift first = driven * share, rest = slide(touching, driven * (1 - share));
  const Twist2 twist{(first.ahead + rest.ahead) / duration, (first.turn + rest.turn) / duration};
  const double distance = std::hypot(first.ahead, first.sideways) + std::hypot(rest.ahead, rest.sideways);
  const double skid = (first.sideways + rest.sideways) / duration;
  return {shifted(touching, rest), {twist, skid}, distance, true, shifted(pose, driven)};
}

}  // namespace

BodyMotion move_body(const SolidMap& map, const ChairConfig& chair, const Pose2& pose, const BodyVelocity& driven,
                     double duration) {
  return Body(map, chair).move(pose, driven, duration);
}

}  // namespace lfdcore
