// Which cells around a robot beams have passed through, and when: a square that travels with it.
#pragma once

#include <cstdint>
#include <vector>

#include "lfdcore/geometry.hpp"
#include "lfdcore/grid/fused_points.hpp"
#include "lfdcore/grid/grid.hpp"

namespace lfdcore {

/// Cells of 0.025 m aligned with the odometry frame, in a square around the robot.
class SeenCells {
 public:
  static constexpr double resolution = 0.025;  ///< [m]

  struct State {
    ScanNumber last_free = 0;   ///< a beam passed through it
    ScanNumber last_clear = 0;  ///< the same, surely (noise cannot have brought it here), or the robot's body was on it
    std::uint32_t crossings = 0;  ///< scans in which it was surely passed, since one that hit it
  };

  /// A square of at least `least_side` [m].
  explicit SeenCells(double least_side);

  /// Of the square, in cells: a power of two, at least 8.
  int side() const { return side_; }

  /// Puts the square around a place [m] and forgets the cells that it leaves; false if it has not moved.
  bool follow(double x, double y);
  void clear();

  /// Of the cell at a place [m]; nothing outside the square.
  const State* at(double x, double y) const;
  /// Whether a beam passed through a cell, or the body was on it, in scan `from` or later; not outside the square.
  static bool is_seen(const State* cell, ScanNumber from);

  /// (side, side) blocks of 2 x 2 cells, from the one with its corner at a place [m] on: true where none of its cells
  /// was passed through, nor under the body, in scan `from` or later.
  Mask unseen_blocks(double x, double y, Eigen::Index side, ScanNumber from) const;

  /// A beam from a place [m] along a unit vector: free up to `length`, surely up to `sure` [m].
  void cross(double x, double y, double dx, double dy, double length, double sure, ScanNumber scan);
  void hit(double x, double y);
  /// Cells with their centre under the body at a pose are clear.
  void cover(const Pose2& pose, const Footprint& body, ScanNumber scan);

  /// True if the cell at a place was surely passed through in 4 scans or more since it was last hit, and all cells with
  /// their centre within 0.1 m of it, or a neighbour of each, were; all for the last time in scan `from` or later.
  bool clear_around(double x, double y, ScanNumber from) const;

 private:
  State* state(std::int64_t ix, std::int64_t iy);
  const State* state(std::int64_t ix, std::int64_t iy) const;
  bool surely_clear(std::int64_t ix, std::int64_t iy, ScanNumber from) const;
  void forget_columns(std::int64_t from, std::int64_t to);
  void forget_rows(std::int64_t from, std::int64_t to);

  int side_;
  std::int64_t corner_ix_ = 0, corner_iy_ = 0;  // absolute cell of the square's corner
  std::vector<State> cells_;                    // a torus: cell (ix, iy) lies at (ix mod side, iy mod side)
};

}  // namespace lfdcore
