// Cost of the cheapest way to the goal for a disc: what a search in (x, y, heading) can at best reach.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "clearance_map.hpp"

namespace lfdcore {

/// A disc that must stay `margin` away from obstacles. A metre costs 1, and `weight` more at clearance 0, less by the
/// square up to `comfort` [m].
struct DiscCost {
  double radius, margin, weight, comfort;
};

/// Dijkstra's distances over every second cell of the clearance map, 8-connected. A cell is blocked only if a disc
/// anywhere in it would hold an obstacle, so that what is unreachable here is so for the body too.
class GoalDistance {
 public:
  explicit GoalDistance(const ClearanceMap& map)
      : side_(map.cells() / 2 + 1), steps_(side_ * side_), factor_(side_ * side_) {}

  /// Costs to the cells that meet a disc of `tolerance` around the goal (relative to the map's middle); false if all
  /// of them are blocked for the disc.
  bool build(const ClearanceMap& map, const Eigen::Vector2d& goal, double tolerance, const DiscCost& disc);

  /// False near the window's border and beyond, where nothing is known.
  bool covers(double x, double y) const {
    return std::max(std::abs(index(x) - side_ / 2), std::abs(index(y) - side_ / 2)) < side_ / 2;
  }
  /// A bound [m] from below for a point relative to the map's middle; infinity if it cannot come to the goal.
  double at(double x, double y) const;

 private:
  static constexpr double cell = 2 * ClearanceMap::resolution;
  static constexpr int straight = 10, diagonal = 14, dearest = 8;
  static constexpr int unreached = std::numeric_limits<int>::max(), blocked = -1;

  int index(double offset) const { return static_cast<int>(std::lround(offset / cell)) + side_ / 2; }
  double offset(int i) const { return cell * (i - side_ / 2); }
  void weigh(const ClearanceMap& map, const DiscCost& disc);
  bool seed(const Eigen::Vector2d& goal, double tolerance);
  void flood();
  void relax(int at, int distance);

  int side_;
  std::vector<int> steps_;                                        // tenths of a cell
  std::vector<float> factor_;                                     // what a metre costs in a cell, at most `dearest`
  std::array<std::vector<int>, diagonal * dearest + 1> buckets_;  // cells by cost modulo their number (Dial's queue)
};

}  // namespace lfdcore
