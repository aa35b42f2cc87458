// Where beams meet the occupied cells of a map: exact, in maps of any size.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lfdcore/grid/grid.hpp"

namespace lfdcore {

/// Casts rays by leaps over empty squares: for each of the four quadrants, every cell knows the side of the largest
/// square with it as a corner that holds no occupied cell, and a ray goes to that square's far edge at once. What it
/// returns is what a walk from cell to cell returns. Takes 4 bytes a cell; immutable, so threads may share it.
class RayCaster {
 public:
  /// range_max [m] > 0; at most 2^31 - 1 cells. Cells count as occupied from 65 %; unknown ones are transparent.
  RayCaster(const OccupancyGrid& grid, double range_max);

  /// For each angle [rad], in the laser's frame, the distance [m] to the point where the ray enters the first occupied
  /// cell; 0 if the laser is in one; infinity if there is none within range_max or before the map's end. A laser
  /// outside the map sees what lies inside. Throws std::invalid_argument for a pose or an angle that is not finite, or
  /// if `ranges` is not as long as `angles`.
  void cast(const Pose2& T_map_laser, std::span<const double> angles, std::span<float> ranges) const;

  double range_max() const { return range_max_; }

 private:
  GridGeometry geometry_;
  double range_max_;                       // [m]
  std::vector<std::uint32_t> free_sides_;  // byte q for quadrant q: bit 0 of q: towards smaller x, bit 1: smaller y
};

}  // namespace lfdcore
