// The Dynamic Window Approach (Fox et al. 1997; App. E.2, Alg. 8; ERRATA 47, F11).
#pragma once

#include "lfdcore/control/command_timing.hpp"
#include "lfdcore/geometry.hpp"
#include "lfdcore/grid/obstacle_points.hpp"
#include "lfdcore/motion.hpp"

namespace lfdcore {

struct DynamicWindowConfig {
  int linear_samples = 11;
  int angular_samples = 21;
  double horizon = 2.0;  ///< each candidate twist is held this long [s]; the thesis states no value
  double step = 0.1;     ///< between the poses tested for collision [s]
};

/// Throws std::invalid_argument, naming the field, for sample counts outside 1..1000, times that are not positive,
/// step > horizon or more than 10000 steps.
void validate(const DynamicWindowConfig& config);

struct DynamicWindowResult {
  Twist2 twist;                                         ///< [m/s, rad/s]
  bool feasible = false;                                ///< false: every candidate collides, `twist` brakes
  Eigen::Vector2d end_point = Eigen::Vector2d::Zero();  ///< where `twist` held over the horizon leads, base_link [m]
  double cost = 0;  ///< distance from end_point to the goal [m]; infinity if not feasible
};

/// The twist, among a grid spanning what `limits` let the chair reach from `current` in one `period` [s] between
/// two commands, whose roll-out over the horizon ends nearest to `goal` [m] (base_link) without the footprint touching
/// an obstacle (points in base_link) at any step after the start. Ties (within 1 nm): the twist nearest to `wanted`;
/// all turns on the spot end alike. There is no initial best (the printed one, the current twist, may collide: ERRATA
/// 47): if every candidate collides, the result brakes at the limit.
///
/// Throws std::invalid_argument for a non-finite twist or goal, an invalid config or limits, or a period that is not
/// positive.
DynamicWindowResult solve_dynamic_window(const Twist2& current, const Eigen::Vector2d& goal,
                                         const ObstaclePoints& obstacles, const Footprint& footprint,
                                         const MotionLimits& limits, const DynamicWindowConfig& config = {},
                                         const Twist2& wanted = {}, double period = CommandTiming{}.period);

}  // namespace lfdcore
