// The obstacle points that a moving body may come near to, laid out for thousands of exact distance queries.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "lfdcore/control/side_contact.hpp"
#include "lfdcore/geometry.hpp"
#include "lfdcore/grid/obstacle_points.hpp"

namespace lfdcore {

/// Signed distance [m] from a point in base_link to the footprint's edge: negative inside.
inline double signed_distance(double x, double y, const Footprint& footprint) {
  const double beyond_x = std::max(x - footprint.front, -footprint.rear - x);
  const double beyond_y = std::abs(y) - footprint.half_width;
  const double outside = std::hypot(std::max(beyond_x, 0.0), std::max(beyond_y, 0.0));
  return outside + std::min(std::max(beyond_x, beyond_y), 0.0);
}

/// What is asked of points while a body moves.
struct Demand {
  double required = 0;  ///< distance [m] to keep, beyond the points' uncertainties
  /// The body goes straight on, but for sideways moves of any part of it of at most this [m]: points that it passes
  /// need keep no more than the distance at which it passes them. Infinity: it does not.
  double sideways = std::numeric_limits<double>::infinity();
};

/// The left side, and the right one; of each, for a way ahead, and for a way back.
using Sides = std::array<std::array<SideContact, 2>, 2>;

/// A subset of ObstaclePoints, each with the distance that it must keep from the footprint.
/// Keeps its memory between calls of gather(): no allocation once it has seen the largest set.
class NearPoints {
 public:
  /// Takes the points (in base_link) within `radius` [m] of the axle, without their uncertainties.
  void gather(const ObstaclePoints& obstacles, double radius);

  /// Takes the points that may be within `radius` [m] of the axle, with their uncertainties. No point will have to keep
  /// more than the distance that it has now (body at the origin): those too near must not come nearer, no more.
  void gather(const ObstaclePoints& obstacles, double radius, const Footprint& footprint);

  /// Looks at both sides, and lets a body that goes straight on pass points
  /// - that are at least `margin` [m] beside its way, and their uncertainty, or
  /// - that are no nearer than a wall which touches that side now, or may (SideContact), or
  /// - that are beside it now: they do not hinder moves of up to 1 mm sideways.
  void let_pass(const Footprint& footprint, double margin, Sides& sides);

  /// Least of (signed distance - distance to keep) [m] over the points, for a body at `pose`; infinity without points.
  /// It changes by no more than the farthest move of any point of the body.
  /// A value of `enough` [m] or less may be returned early: then it is the slack of some point, not the least.
  double slack(const Pose2& pose, const Footprint& footprint, const Demand& demand = {},
               double enough = -std::numeric_limits<double>::infinity());

  /// Number of points taken.
  std::size_t size() const { return count_; }

 private:
  void make_room(std::size_t points);
  void append(double x, double y, double uncertainty, double most);
  void pad();
  bool look_at(Sides& sides, const Footprint& footprint, double margin) const;  // whether anything may touch
  void let_pass_along(const Sides& sides, const Footprint& footprint);
  bool is_beside(std::size_t i, double beside) const { return most_[i] == beside; }  // the side is what is nearest

  std::size_t count_ = 0, last_hit_ = 0;
  // Of each point, padded to whole vectors with points far away. Distances to keep: at most `most`; while it is passed,
  // `passing` less the sideways moves, if that is `least_passing` or more. A point that is not passed: -infinity, 0.
  std::vector<double> x_, y_, uncertainty_, most_, passing_, least_passing_;
};

}  // namespace lfdcore
