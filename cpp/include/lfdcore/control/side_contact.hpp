// What runs along a side of a chair so near that it may touch: how near the chair may pass what comes next.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

namespace lfdcore {

/// One side of a chair that creeps straight ahead (or back) beside a wall which it touches, or may touch. The next
/// points of this wall may be passed as near as the wall is.
///
/// How near it is: the least distance within which points span half of the chair's length, be they beside it or passed
/// already. A single point, as of a foot, does not, and of a wall that comes nearer, the leading corner alone is near.
/// But noise hides a slight inclination, and a wall measured anew in each tick would be followed to any depth. So the
/// greatest distance counts since the wall came near, or since the driver let the stick go.
class SideContact {
 public:
  static constexpr double near = 0.025;  ///< [m] beside: what is farther away does not touch, however unsure
  /// [m] inside the outline: what is measured deeper, by more than its uncertainty, is no wall. An uncertainty counts
  /// up to as much.
  static constexpr double deepest = 0.01;
  static constexpr double roughness = 0.001;  ///< [m] by which a wall's next point may be nearer, besides uncertainty

  /// Forgets how near the wall was.
  void let_go() { held_ = -std::numeric_limits<double>::infinity(); }

  /// Begins a new look at the side.
  void look();

  /// Whether a point that is so far beside (below 0 inside), and so uncertain, may belong to a wall that touches [m].
  static bool may_belong(double beside, double uncertainty) {
    return beside < near && beside >= -deepest - allowance(uncertainty);
  }

  /// Such a point that is beside the chair, or was passed: how far ahead of the axle it is, and how far beside [m].
  void add(double ahead, double beside) { points_.push_back({beside, ahead}); }

  /// Ends the look. `span`: half of the chair's length [m]. `may_touch`: something beside the chair may touch it.
  void measure(double span, bool may_touch);

  /// The least distance [m] beside the way at which a point of this uncertainty may be passed as the wall's next one;
  /// infinity where nothing may touch the side.
  double least(double uncertainty) const;

 private:
  struct Point {
    double beside, ahead;
  };
  static double allowance(double uncertainty) { return std::min(uncertainty, deepest); }
  double level(double span);

  std::vector<Point> points_;
  bool may_touch_ = false;
  double held_ = -std::numeric_limits<double>::infinity();  // [m]: below `near`, or none
};

}  // namespace lfdcore
