#include "lfdcore/simulation/person_contact.hpp"

#include <algorithm>

namespace lfdcore {
namespace {

/// The outline's point that is nearest to a person, in base_link.
struct Nearest {
  Eigen::Vector2d point, outwards;  // outwards: towards the person's centre, from inside away from the body
  OutlinePart part;
  double distance;  // of the person's centre, negative inside
};

OutlinePart part_of(const Eigen::Vector2d& point, const Footprint& body) {
  if (point.x() >= body.front) return OutlinePart::nose;
  if (point.x() <= -body.rear) return OutlinePart::rear;
  return point.y() > 0 ? OutlinePart::left : OutlinePart::right;
}

Nearest from_inside(const Eigen::Vector2d& centre, const Footprint& body) {
  const std::array<double, 4> depth{body.front - centre.x(), body.half_width - centre.y(), body.half_width + centre.y(),
                                    body.rear + centre.x()};
  constexpr std::array parts{OutlinePart::nose, OutlinePart::left, OutlinePart::right, OutlinePart::rear};
  const std::array<Eigen::Vector2d, 4> normals{{{1, 0}, {0, 1}, {0, -1}, {-1, 0}}};
  const auto side = std::min_element(depth.begin(), depth.end()) - depth.begin();
  return {centre + depth[side] * normals[side], normals[side], parts[side], -depth[side]};
}

Nearest nearest(const Eigen::Vector2d& centre, const Footprint& body) {
  const Eigen::Vector2d point(std::clamp(centre.x(), -body.rear, body.front),
                              std::clamp(centre.y(), -body.half_width, body.half_width));
  const double distance = (centre - point).norm();
  if (distance == 0) return from_inside(centre, body);
  return {point, (centre - point) / distance, part_of(point, body), distance};
}

double approach_of_chair(const Twist2& twist, const Nearest& near) {
  const Eigen::Vector2d velocity(twist.linear - twist.angular * near.point.y(), twist.angular * near.point.x());
  return velocity.dot(near.outwards);
}

PersonContact begun(const Pose2& pose, const Twist2& twist, const Person& person, const Nearest& near) {
  PersonContact contact;
  contact.pose = pose;
  contact.twist = twist;
  contact.position = person.position;
  contact.velocity = person.velocity;
  contact.point = near.point;
  contact.part = near.part;
  contact.chair_approach = contact.chair_approach_since = approach_of_chair(twist, near);
  contact.person_approach = -(Pose2{0, 0, -pose.yaw} * person.velocity).dot(near.outwards);
  return contact;
}

}  // namespace

void PersonContacts::note(double stamp, const Pose2& pose, const Twist2& twist, const ChairConfig& chair,
                          std::span<const Person> people, double duration) {
  touches_.resize(people.size());
  const Pose2 T_base_map = pose.inverse();
  for (std::size_t number = 0; number < people.size(); ++number) {
    const Person& person = people[number];
    const Nearest near = nearest(T_base_map * person.position, chair.footprint);
    const double gap = near.distance - person.radius;
    Touch& touch = touches_[number];
    if (gap <= 0 && touch.contact < 0) {
      touch.contact = static_cast<int>(all_.size());
      all_.push_back(begun(pose, twist, person, near));
      all_.back().person = static_cast<int>(number);
      all_.back().stamp = stamp;
    }
    if (touch.contact < 0) continue;
    double& fastest = all_[touch.contact].chair_approach_since;
    if (gap <= 0 && near.distance > 0) fastest = std::max(fastest, approach_of_chair(twist, near));
    touch.clear_time = gap > chair.contact.release_gap ? touch.clear_time + duration : 0;
    if (touch.clear_time >= chair.contact.release_time - 1e-9) touch = {};
  }
}

bool PersonContacts::touching() const {
  return std::any_of(touches_.begin(), touches_.end(), [](const Touch& touch) { return touch.contact >= 0; });
}

}  // namespace lfdcore
