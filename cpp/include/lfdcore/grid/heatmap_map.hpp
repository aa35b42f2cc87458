// Local heatmaps put together along a drive (Alg. 4).
#pragma once

#include <cstdint>

#include "lfdcore/grid/grid.hpp"

namespace lfdcore {

/// The mean heat of each cell of a map over all frames that saw it. Several cells of a frame that fall into one cell of
/// the map all count (ERRATA 32).
class HeatmapMap {
 public:
  /// Laid over a map, cell by cell.
  explicit HeatmapMap(const OccupancyGrid& map);

  /// Adds the visible cells of a local heatmap (100, 100), scaled to a maximum of 1 among them, at the pose of
  /// base_link in the map. A frame that is 0 in all of them counts as seen, with heat 0. Returns the number of visible
  /// cells that lay outside the map. Throws std::invalid_argument, and adds nothing, for other shapes, heat that is
  /// negative or not finite, or a pose that is not finite.
  int insert(const FloatGrid& heatmap, const Mask& visible, const Pose2& T_map_base);

  /// H_concat (height, width): mean heat, in [0, 1]; 0 where no frame saw the cell.
  FloatGrid heatmap() const;
  /// C (height, width): how many local cells fell into each.
  const GridOf<std::int32_t>& count() const { return count_; }
  const GridGeometry& geometry() const { return geometry_; }

 private:
  GridGeometry geometry_;
  GridOf<double> sum_;
  GridOf<std::int32_t> count_;
};

}  // namespace lfdcore
