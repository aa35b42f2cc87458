// Occupancy grids as nav_msgs/OccupancyGrid: data(iy, ix), origin = corner of cell (0, 0), values 0..100 and -1.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "lfdcore/geometry.hpp"

namespace lfdcore {

template <class T>
using GridOf = Eigen::Array<T, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using FloatGrid = GridOf<float>;
using Mask = GridOf<bool>;

/// A cell's column and row.
struct Cell {
  int ix = 0, iy = 0;
  bool operator==(const Cell&) const = default;
};

inline constexpr std::int8_t free_cell = 0, occupied_cell = 100, unknown_cell = -1;
/// A cell counts as occupied from this value on [%] (map_server's occupied_thresh 0.65).
inline constexpr std::int8_t occupied_from = 65;

/// Where the cells lie: size, resolution [m] and the corner of cell (0, 0) [m] in the grid's frame (axis-aligned).
struct GridGeometry {
  int width = 0, height = 0;
  double resolution = 0.05;
  double origin_x = 0, origin_y = 0;

  bool contains(Cell cell) const { return cell.ix >= 0 && cell.iy >= 0 && cell.ix < width && cell.iy < height; }
  Cell cell_at(double x, double y) const {
    return {static_cast<int>(std::floor((x - origin_x) / resolution)),
            static_cast<int>(std::floor((y - origin_y) / resolution))};
  }
  /// Centre of a cell [m].
  Eigen::Vector2d centre(Cell cell) const {
    return {origin_x + (cell.ix + 0.5) * resolution, origin_y + (cell.iy + 0.5) * resolution};
  }
};

/// The window around the robot (Sec. 3.3): 5 x 5 m in 0.05 m cells, always 100 x 100, base_link at its centre.
inline GridGeometry local_window() { return {100, 100, 0.05, -2.5, -2.5}; }

struct OccupancyGrid {
  GridGeometry geometry;
  GridOf<std::int8_t> data;  ///< (height, width)

  OccupancyGrid() = default;
  /// All cells `value`; throws std::invalid_argument for a size or resolution that is not positive.
  OccupancyGrid(const GridGeometry& where, std::int8_t value);
  OccupancyGrid(const GridGeometry& where, GridOf<std::int8_t> cells);

  bool occupied(Cell cell) const { return data(cell.iy, cell.ix) >= occupied_from; }
  /// (height, width): true where occupied.
  Mask occupied_mask() const { return data >= occupied_from; }
};

}  // namespace lfdcore
