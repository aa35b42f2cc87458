// Refusal of poses that cannot be laid on a grid.
#pragma once

#include <string>

#include "lfdcore/error.hpp"
#include "lfdcore/geometry.hpp"

namespace lfdcore {

inline constexpr double farthest = 1e7;  // [m] beyond it a 0.05 m cell's index is no longer worth its digits

/// Throws std::invalid_argument unless the position lies within 1e7 m of the origin and the heading is finite.
inline void require_pose(const char* what, const Pose2& pose) {
  if (std::abs(pose.x) <= farthest && std::abs(pose.y) <= farthest && std::isfinite(pose.yaw)) return;
  const std::string name = what;
  require_between(name + ".x", pose.x, -farthest, farthest, "m");
  require_between(name + ".y", pose.y, -farthest, farthest, "m");
  require_finite(name + ".yaw", pose.yaw, "rad");
}

}  // namespace lfdcore
