#include "motion_primitives.hpp"

#include "lfdcore/grid/swept_contact.hpp"

namespace lfdcore {
namespace {

/// Growth at which halving ends [m]: a few checks more against gaps wrongly held too narrow.
constexpr double finest = 0.01;
/// The path's points are at most this far apart [m, rad].
constexpr double path_step = 0.05, path_turn = 0.1;

std::vector<Interval> intervals(const Footprint& footprint, const Twist2& move) {
  std::vector<Interval> heap(1);
  for (int parts = 1;; parts *= 2) {
    const Footprint held = swept(footprint, move.linear / parts, move.angular / parts);
    const double along = held.front - footprint.front, across = held.half_width - footprint.half_width;
    const bool last = std::max(along, across) <= finest;
    for (int i = 0; i < parts; ++i) heap.push_back({integrate({}, move, (i + 0.5) / parts), along, across, last});
    if (last) return heap;
  }
}

MotionPrimitive primitive(const Footprint& footprint, double length, double turn) {
  const Twist2 move{length, turn};
  MotionPrimitive made{length, turn, length == 0 ? 0 : turn / length, intervals(footprint, move), {}};
  const int count =
      static_cast<int>(std::ceil(std::max(std::abs(length) / path_step, std::abs(turn) / path_turn) - 1e-9));
  for (int i = 1; i <= count; ++i) made.poses.push_back(integrate({}, move, static_cast<double>(i) / count));
  return made;
}

}  // namespace

std::vector<MotionPrimitive> motion_primitives(const Footprint& footprint, bool reverse) {
  std::vector<MotionPrimitive> made;
  for (const double length : {move_length, -move_length}) {
    if (length < 0 && !reverse) continue;
    for (const double curvature : {0.0, 0.6, -0.6, 1.3, -1.3, tightest_curvature, -tightest_curvature})
      made.push_back(primitive(footprint, length, length * curvature));
  }
  for (const double turn : {heading_step, -heading_step}) made.push_back(primitive(footprint, 0, turn));
  return made;
}

}  // namespace lfdcore
