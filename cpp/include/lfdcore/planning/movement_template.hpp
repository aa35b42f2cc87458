// Which stick leads where: the movement template and the distance filter of Sec. 4.4.1.
#pragma once

#include "lfdcore/grid/grid.hpp"
#include "lfdcore/motion.hpp"

namespace lfdcore {

/// The stick's orientation h = arctan2(left, forward) in (-pi, pi] whose constant twist leads base_link's origin
/// through a point [m]: along the arc tangent to the chair's heading, ahead for x >= 0, else backwards, turned by at
/// most 180 degrees. With kappa = 2 y / (x^2 + y^2): arctan2(kappa max_linear / max_angular, 1) ahead (ERRATA 28),
/// arctan2(-kappa max_reverse / max_angular, -1) backwards. Throws std::invalid_argument for a point that is not finite
/// or is the origin, through which all arcs lead, or for limits that are not positive.
double arc_orientation(const Eigen::Vector2d& point, const MotionLimits& limits);

/// Both matrices of Sec. 4.4.1 over the local window, for a chair with certain limits. Built once, in some 100 ms, from
/// a fan of arcs dense enough to reach all cells: each stops at the window's edge or when turned by 180 degrees; those
/// ahead cover the front half, those backwards the rear half (ERRATA 28).
class MovementTemplate {
 public:
  explicit MovementTemplate(const MotionLimits& limits = {});

  const MotionLimits& limits() const { return limits_; }
  /// (100, 100): circular mean of h over the arcs through a cell [rad], within (-pi, pi].
  const FloatGrid& orientation() const { return orientation_; }
  /// (100, 100): their mean length up to the cell, divided by the largest, within (0, 1].
  const FloatGrid& distance_filter() const { return distance_filter_; }

 private:
  MotionLimits limits_;
  FloatGrid orientation_, distance_filter_;
};

}  // namespace lfdcore
