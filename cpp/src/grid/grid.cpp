#include "lfdcore/grid/grid.hpp"

#include <string>
#include <utility>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

void check(const GridGeometry& where) {
  require(where.width > 0 && where.height > 0, "grid size is " + std::to_string(where.width) + " x " +
                                                   std::to_string(where.height) + " cells, must be at least 1 x 1");
  require_positive("grid resolution", where.resolution, "m");
  require_finite("grid origin x", where.origin_x, "m");
  require_finite("grid origin y", where.origin_y, "m");
}

}  // namespace

OccupancyGrid::OccupancyGrid(const GridGeometry& where, std::int8_t value) : geometry(where) {
  check(where);
  data.setConstant(where.height, where.width, value);
}

OccupancyGrid::OccupancyGrid(const GridGeometry& where, GridOf<std::int8_t> cells)
    : geometry(where), data(std::move(cells)) {
  check(where);
  require(data.rows() == where.height && data.cols() == where.width,
          "grid data is " + std::to_string(data.rows()) + " x " + std::to_string(data.cols()) + ", must be " +
              std::to_string(where.height) + " x " + std::to_string(where.width) + " (height x width)");
  require((data >= -1).all() && (data <= 100).all(), "grid data must lie in -1..100 [%]");
}

}  // namespace lfdcore
