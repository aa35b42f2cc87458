// The moves of the hybrid A* search, each with the poses and swept rectangles to check it by.
#pragma once

#include <vector>

#include "lfdcore/geometry.hpp"

namespace lfdcore {

inline constexpr int headings = 32;
inline constexpr double heading_step = 2 * pi / headings;
inline constexpr double move_length = 0.15;        // [m]
inline constexpr double tightest_curvature = 2.2;  // [1/m]

/// Part of a move: its middle relative to the move's start, and what the sweep over it adds to the footprint [m].
struct Interval {
  Pose2 middle;
  double along, across;
  bool last;  ///< so small that a hit counts
};

struct MotionPrimitive {
  double length, turn, curvature;   ///< [m] (negative: backwards), [rad], [1/m]
  std::vector<Interval> intervals;  ///< as a heap: interval 1 is the whole move, the halves of i are 2 i and 2 i + 1
  std::vector<Pose2> poses;         ///< along the move, the last one its end

  bool pivots() const { return length == 0; }
  const Pose2& end() const { return poses.back(); }
};

/// Arcs ahead, turns in place and, if asked for, arcs backwards.
std::vector<MotionPrimitive> motion_primitives(const Footprint& footprint, bool reverse);

}  // namespace lfdcore
