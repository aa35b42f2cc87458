// Bounds on the distance to the nearest obstacle point, for tests that need not be exact.
#pragma once

#include <cstdint>
#include <numbers>
#include <vector>

#include "lfdcore/geometry.hpp"
#include "lfdcore/grid/obstacle_points.hpp"

namespace lfdcore {

/// Distances between cells of a square window whose middle cell is centred on a point, up to `reach`.
class ClearanceMap {
 public:
  static constexpr double resolution = 0.05;  // [m]
  static constexpr int reach = 20;            // [cells]

  explicit ClearanceMap(double half_width);

  /// Forgets the old obstacles and takes those within the window around a point.
  void build(const ObstaclePoints& obstacles, const Eigen::Vector2d& middle);

  int cells() const { return cells_; }
  /// Column or row of a coordinate relative to the middle [m]; may lie outside.
  int index(double offset) const { return static_cast<int>(std::lround(offset / resolution)) + cells_ / 2; }
  bool contains(int ix, int iy) const { return ix >= 0 && iy >= 0 && ix < cells_ && iy < cells_; }
  /// No obstacle is nearer to (x, y) than this [m]; what lies outside the window is not known and counts as obstacle.
  double at_least(double x, double y) const;
  /// An obstacle lies as near to the cell's centre as this [m], unless it is `reach`.
  double at_most(int ix, int iy) const;

 private:
  double distance(int ix, int iy) const {
    return resolution * std::sqrt(static_cast<double>(squared_[iy * cells_ + ix]));
  }
  void spread_along_columns();
  void spread_along_rows();

  int cells_;
  Eigen::Vector2d middle_{0, 0};
  std::vector<std::uint16_t> squared_;  // cells^2; first within the column, then in the plane
  std::vector<std::uint16_t> padded_;   // one row with `reach` far cells on either side
};

}  // namespace lfdcore
