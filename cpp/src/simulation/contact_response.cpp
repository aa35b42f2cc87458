#include "lfdcore/simulation/contact_response.hpp"

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

class Body {
 public:
  Body(const SolidMap& map, const ChairConfig& chair) : map_(map), chair_(chair) {}

  BodyMotion move(const Pose2& pose, const Twist2& twist, double duration) const;

 private:
  bool free(const Pose2& pose, const Shift& shift) const;
  double free_share(const Pose2& pose, const Shift& shift) const;
  Shift on_cone(const Shift& driven, double away, double around) const;
  Shift slide(const Pose2& pose, const Shift& driven) const;
  Shift nearest_on_ray(const Pose2& pose, const Shift& driven, double held, double free, double around) const;

  const SolidMap& map_;
  const ChairConfig& chair_;
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

/// The displacement at an angle `away` from the driven one, with ahead, turn and skid scaled by the roots of their
/// masses; `around` is 0 and pi without skid, +-pi/2 with nothing but skid. Its length is the driven one's projection,
/// shortened by friction: cos(away) - friction * sin(away).
Shift Body::on_cone(const Shift& driven, double away, double around) const {
  const double radius = chair_.contact.gyration_radius;
  const double ahead = driven.ahead, turn = driven.turn * radius;
  const double along = std::cos(away), across = std::sin(away);
  const double length = along - chair_.contact.friction * across;
  const double tilt = across * std::cos(around),
               skid = across * std::sin(around) / std::sqrt(chair_.contact.skid_resistance);
  return Shift{along * ahead - tilt * turn, skid * std::hypot(ahead, turn), (along * turn + tilt * ahead) / radius} *
         length;
}

/// On the way from an angle that is blocked to one that is free, the smallest angle that is free.
Shift Body::nearest_on_ray(const Pose2& pose, const Shift& driven, double held, double free_away, double around) const {
  for (int i = 0; i < 4; ++i) {
    const double middle = (held + free_away) / 2;
    (free(pose, on_cone(driven, middle, around)) ? free_away : held) = middle;
  }
  return on_cone(driven, free_away, around);
}

/// Cones around the driven displacement, wider and wider, until one holds a free displacement; none if friction holds.
Shift Body::slide(const Pose2& pose, const Shift& driven) const {
  constexpr double width = pi / 20;
  constexpr int rays = 16;
  // Without skid first, then little by little to either side.
  constexpr std::array<int, rays> order{0, 8, 1, 15, 7, 9, 2, 14, 6, 10, 3, 13, 5, 11, 4, 12};
  const double sticking = std::atan2(1.0, chair_.contact.friction);
  for (double away = width; away < sticking; away += width)
    for (const int ray : order)
      if (const double around = ray * 2 * pi / rays; free(pose, on_cone(driven, away, around)))
        return nearest_on_ray(pose, driven, away - width, away, around);
  return {};
}

BodyMotion Body::move(const Pose2& pose, const Twist2& twist, double duration) const {
  const Shift driven{twist.linear * duration, 0, twist.angular * duration};
  if (free(pose, driven)) return {shifted(pose, driven), twist, std::abs(driven.ahead), false, {}};
  const double share = free_share(pose, driven);
  const Pose2 touching = shifted(pose, driven * share);
  const Shift rest = slide(touching, driven * (1 - share));
  const Twist2 turned{(share * driven.ahead + rest.ahead) / duration, (share * driven.turn + rest.turn) / duration};
  const double distance = std::abs(share * driven.ahead) + std::hypot(rest.ahead, rest.sideways);
  return {shifted(touching, rest), turned, distance, true, shifted(pose, driven)};
}

}  // namespace

BodyMotion move_body(const SolidMap& map, const ChairConfig& chair, const Pose2& pose, const Twist2& twist,
                     double duration) {
  return Body(map, chair).move(pose, twist, duration);
}

}  // namespace lfdcore
