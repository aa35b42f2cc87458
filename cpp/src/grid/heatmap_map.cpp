#include "lfdcore/grid/heatmap_map.hpp"

#include <cmath>
#include <optional>
#include <string>

#include "lfdcore/error.hpp"
#include "pose_check.hpp"

namespace lfdcore {
namespace {

void require_window(const char* name, Eigen::Index rows, Eigen::Index cols) {
  const GridGeometry window = local_window();
  require(rows == window.height && cols == window.width, std::string(name) + " is " + std::to_string(rows) + " x " +
                                                             std::to_string(cols) +
                                                             ", must be 100 x 100, the local window");
}

// The cell that holds a point; compared before it becomes an int, since a tiny resolution puts the map's end far off.
std::optional<Cell> cell_inside(const GridGeometry& grid, const Eigen::Vector2d& point) {
  const double column = std::floor((point.x() - grid.origin_x) / grid.resolution);
  const double row = std::floor((point.y() - grid.origin_y) / grid.resolution);
  if (!(column >= 0 && row >= 0 && column < grid.width && row < grid.height)) return std::nullopt;
  return Cell{static_cast<int>(column), static_cast<int>(row)};
}

}  // namespace

HeatmapMap::HeatmapMap(const OccupancyGrid& map) : geometry_(map.geometry) {
  sum_ = GridOf<double>::Zero(geometry_.height, geometry_.width);
  count_ = GridOf<std::int32_t>::Zero(geometry_.height, geometry_.width);
}

int HeatmapMap::insert(const FloatGrid& heatmap, const Mask& visible, const Pose2& T_map_base) {
  require_window("heatmap", heatmap.rows(), heatmap.cols());
  require_window("visible", visible.rows(), visible.cols());
  require((heatmap >= 0).all() && heatmap.allFinite(), "heatmap holds values that are negative or not finite");
  require_pose("T_map_base", T_map_base);
  const GridGeometry window = local_window();
  const double largest = visible.select(heatmap, 0.0f).maxCoeff(), scale = largest > 0 ? 1 / largest : 0;
  int outside = 0;
  for (int iy = 0; iy < window.height; ++iy) {
    for (int ix = 0; ix < window.width; ++ix) {
      if (!visible(iy, ix)) continue;
      const Eigen::Vector2d point = T_map_base * window.centre({ix, iy});
      const std::optional<Cell> cell = cell_inside(geometry_, point);
      if (!cell) {
        ++outside;
        continue;
      }
      sum_(cell->iy, cell->ix) += scale * heatmap(iy, ix);
      count_(cell->iy, cell->ix) += 1;
    }
  }
  return outside;
}

FloatGrid HeatmapMap::heatmap() const {
  return (count_ > 0).select(sum_ / count_.max(1).cast<double>(), 0.0).cast<float>();
}

}  // namespace lfdcore
