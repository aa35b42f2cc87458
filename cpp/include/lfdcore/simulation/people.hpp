// People at the height of the scanner: discs that walk, and what the beams of a LIDAR meet of them.
#pragma once

#include <span>

#include "lfdcore/geometry.hpp"

namespace lfdcore {

/// A whole person as one disc: body, both legs and the room of a stride. It walks on at its velocity.
struct Person {
  Eigen::Vector2d position{0, 0};  ///< of the disc's centre in map [m]
  Eigen::Vector2d velocity{0, 0};  ///< [m/s]
  double radius = 0.25;            ///< [m]
};

/// Throws std::invalid_argument, naming the field, for a value that is not finite or out of its range: a position
/// within 1e6 m, at most 10 m/s along each axis, 0 < radius <= 5 m.
void validate(const Person& person);

/// The beam's angle in the laser's frame as a direction of length 1.
inline Eigen::Vector2d beam_direction(double angle) { return {std::cos(angle), std::sin(angle)}; }

/// Shortens the ranges [m] of beams with these directions (laser's frame) that meet a person's disc, exactly: to the
/// distance at which the beam enters it, 0 for a laser in it; beyond range_max [m] nothing is met. Where `met` is not
/// empty it gets for each beam the number of the person that ends it, or keeps what it holds.
void cast_at_people(const Pose2& T_map_laser, std::span<const Eigen::Vector2d> directions, double range_max,
                    std::span<const Person> people, std::span<float> ranges, std::span<int> met = {});

}  // namespace lfdcore
