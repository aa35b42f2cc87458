// Length of the shortest way to the goal for a disc: what a search in (x, y, heading) can at best reach.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "clearance_map.hpp"

namespace lfdcore {

/// Dijkstra's distances over every second cell of the clearance map, 8-connected. A cell is blocked only if a disc
/// anywhere in it would hold an obstacle, so that what is unreachable here is so for the body too.
class GoalDistance {
 public:
  explicit GoalDistance(const ClearanceMap& map) : side_(map.cells() / 2 + 1), steps_(side_ * side_) {}

  /// Distances to the cells that meet a disc of `tolerance` around the goal (relative to the map's middle); false if
  /// all of them are blocked for a disc of `radius`.
  bool build(const ClearanceMap& map, const Eigen::Vector2d& goal, double tolerance, double radius);

  /// A bound [m] from below for a point relative to the map's middle; infinity if it cannot come to the goal.
  double at(double x, double y) const;

 private:
  static constexpr double cell = 2 * ClearanceMap::resolution;
  static constexpr int straight = 5, diagonal = 7, unreached = std::numeric_limits<int>::max(), blocked = -1;

  int index(double offset) const { return static_cast<int>(std::lround(offset / cell)) + side_ / 2; }
  double offset(int i) const { return cell * (i - side_ / 2); }
  void block(const ClearanceMap& map, double radius);
  bool seed(const Eigen::Vector2d& goal, double tolerance);
  void flood();
  void relax(int at, int distance);

  int side_;
  std::vector<int> steps_;                              // fifths of a cell
  std::array<std::vector<int>, diagonal + 1> buckets_;  // cells by distance modulo 8 (Dial's queue)
};

}  // namespace lfdcore
