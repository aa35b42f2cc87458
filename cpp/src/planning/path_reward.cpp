#include "lfdcore/planning/path_reward.hpp"

#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

constexpr double farthest_cell = 1e5;

Cell checked_cell(const GridGeometry& grid, double x, double y) {
  require_finite("path point x", x, "m");
  require_finite("path point y", y, "m");
  require_between("path point x", (x - grid.origin_x) / grid.resolution, -farthest_cell, farthest_cell,
                  "cells from the grid's corner");
  require_between("path point y", (y - grid.origin_y) / grid.resolution, -farthest_cell, farthest_cell,
                  "cells from the grid's corner");
  return grid.cell_at(x, y);
}

// Bresenham's line, without its first cell.
void append_line(Cell at, Cell end, std::vector<Cell>& cells) {
  const int dx = std::abs(end.ix - at.ix), dy = -std::abs(end.iy - at.iy);
  const int step_x = at.ix < end.ix ? 1 : -1, step_y = at.iy < end.iy ? 1 : -1;
  int error = dx + dy;
  while (!(at == end)) {
    const int twice = 2 * error;
    if (twice >= dy) error += dy, at.ix += step_x;
    if (twice <= dx) error += dx, at.iy += step_y;
    cells.push_back(at);
  }
}

// Normalised Gaussian weights of -radius..radius, cut off at 4 sigma (as scipy.ndimage.gaussian_filter).
std::vector<float> gaussian_taps(double sigma) {
  const int radius = static_cast<int>(4 * sigma + 0.5);
  std::vector<double> weights;
  double sum = 0;
  for (int i = -radius; i <= radius; ++i) sum += weights.emplace_back(std::exp(-0.5 * i * i / (sigma * sigma)));
  std::vector<float> taps;
  for (const double weight : weights) taps.push_back(static_cast<float>(weight / sum));
  return taps;
}

// Correlates every column with the taps; zeros around the grid.
FloatGrid blurred_columns(const FloatGrid& map, const std::vector<float>& taps) {
  const auto rows = map.rows(), radius = static_cast<Eigen::Index>(taps.size() / 2);
  FloatGrid sum = FloatGrid::Zero(rows, map.cols());
  for (Eigen::Index offset = -std::min(radius, rows - 1); offset <= std::min(radius, rows - 1); ++offset) {
    const auto count = rows - std::abs(offset);
    const auto to = std::max<Eigen::Index>(0, -offset);
    sum.middleRows(to, count) += taps[radius + offset] * map.middleRows(to + offset, count);
  }
  return sum;
}

FloatGrid blurred(const FloatGrid& map, double sigma) {
  if (sigma == 0) return map;
  const auto taps = gaussian_taps(sigma);
  const FloatGrid turned = blurred_columns(map, taps).transpose();
  return blurred_columns(turned, taps).transpose();
}

void set_border(FloatGrid& map, float value) {
  map.row(0) = value;
  map.row(map.rows() - 1) = value;
  map.col(0) = value;
  map.col(map.cols() - 1) = value;
}

void set_path(FloatGrid& map, const CellPath& path, const RewardConfig& config) {
  for (Eigen::Index i = 0; i < path.rows(); ++i) {
    const int ix = path(i, 0), iy = path(i, 1);
    require(ix >= 0 && iy >= 0 && ix < map.cols() && iy < map.rows(),
            "path cell " + std::to_string(i) + " is (" + std::to_string(ix) + ", " + std::to_string(iy) +
                "), must lie in the grid of " + std::to_string(map.cols()) + " x " + std::to_string(map.rows()) +
                " cells (width x height)");
    const float along = path.rows() > 1 ? static_cast<float>(i) / static_cast<float>(path.rows() - 1) : 1.0f;
    map(iy, ix) = config.path_first + along * (config.path_last - config.path_first);
  }
}

}  // namespace

void validate(const RewardConfig& config) {
  require_finite("obstacle", config.obstacle, "");
  require_finite("border", config.border, "");
  require_finite("path_first", config.path_first, "");
  require_finite("path_last", config.path_last, "");
  require_between("blur_sigma", config.blur_sigma, 0, 1000, "cells");
}

CellPath path_cells(const Path& path, const GridGeometry& grid) {
  std::vector<Cell> cells;
  for (Eigen::Index i = 0; i < path.rows(); ++i) {
    const Cell cell = checked_cell(grid, path(i, 0), path(i, 1));
    if (i == 0) cells.push_back(cell);
    append_line(cells.back(), cell, cells);
  }
  std::erase_if(cells, [&](Cell cell) { return !grid.contains(cell); });
  CellPath result(static_cast<Eigen::Index>(cells.size()), 2);
  for (Eigen::Index i = 0; i < result.rows(); ++i) result.row(i) << cells[i].ix, cells[i].iy;
  return result;
}

FloatGrid path_reward(const Mask& occupied, const CellPath& path, const RewardConfig& config) {
  validate(config);
  require(occupied.size() > 0, "occupied is " + std::to_string(occupied.rows()) + " x " +
                                   std::to_string(occupied.cols()) + ", must have at least 1 x 1 cells");
  FloatGrid forbidden = FloatGrid::Zero(occupied.rows(), occupied.cols());
  set_border(forbidden, config.border);
  forbidden = occupied.select(config.obstacle, forbidden);
  FloatGrid reward = blurred(forbidden, config.blur_sigma);
  set_path(reward, path, config);
  set_border(reward, config.border);
  return occupied.select(config.obstacle, reward);
}

}  // namespace lfdcore
