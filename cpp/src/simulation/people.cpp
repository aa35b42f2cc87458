#include "lfdcore/simulation/people.hpp"

#include <limits>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

/// Distance [m] at which a ray from the origin enters a disc; infinity for one that misses it.
double entry(const Eigen::Vector2d& direction, const Eigen::Vector2d& centre, double radius) {
  if (centre.squaredNorm() <= radius * radius) return 0;
  const double along = centre.dot(direction);
  const double aside = direction.x() * centre.y() - direction.y() * centre.x();
  if (along < 0 || std::abs(aside) > radius) return std::numeric_limits<double>::infinity();
  return along - std::sqrt(radius * radius - aside * aside);
}

}  // namespace

void validate(const Person& person) {
  require_between("position.x of a person", person.position.x(), -1e6, 1e6, "m");
  require_between("position.y of a person", person.position.y(), -1e6, 1e6, "m");
  require_between("velocity.x of a person", person.velocity.x(), -10, 10, "m/s");
  require_between("velocity.y of a person", person.velocity.y(), -10, 10, "m/s");
  require_positive("radius of a person", person.radius, "m");
  require_between("radius of a person", person.radius, 0, 5, "m");
}

void cast_at_people(const Pose2& T_map_laser, std::span<const Eigen::Vector2d> directions, double range_max,
                    std::span<const Person> people, std::span<float> ranges, std::span<int> met) {
  const Pose2 T_laser_map = T_map_laser.inverse();
  for (std::size_t number = 0; number < people.size(); ++number) {
    const Eigen::Vector2d centre = T_laser_map * people[number].position;
    for (std::size_t beam = 0; beam < directions.size(); ++beam) {
      const double range = entry(directions[beam], centre, people[number].radius);
      if (range > range_max || !(static_cast<float>(range) < ranges[beam])) continue;
      ranges[beam] = static_cast<float>(range);
      if (!met.empty()) met[beam] = static_cast<int>(number);
    }
  }
}

}  // namespace lfdcore
