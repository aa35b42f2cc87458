#include "lfdcore/grid/seen_cells.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "lfdcore/grid/cell_walk.hpp"

namespace lfdcore {
namespace {

constexpr std::uint32_t sure_crossings = 4;
constexpr double neighbourhood = 0.1;  // [m]

std::int64_t cell_of(double metres) {
  const double cells = metres / SeenCells::resolution;
  const auto towards_zero = static_cast<std::int64_t>(cells);
  return towards_zero - (static_cast<double>(towards_zero) > cells ? 1 : 0);
}

}  // namespace

SeenCells::SeenCells(double least_side)
    : side_(static_cast<int>(std::bit_ceil(static_cast<unsigned>(std::ceil(least_side / resolution))))),
      cells_(static_cast<std::size_t>(side_) * side_) {}

void SeenCells::clear() { std::fill(cells_.begin(), cells_.end(), State{}); }

SeenCells::State* SeenCells::state(std::int64_t ix, std::int64_t iy) {
  return const_cast<State*>(std::as_const(*this).state(ix, iy));
}

const SeenCells::State* SeenCells::state(std::int64_t ix, std::int64_t iy) const {
  const std::int64_t from_left = ix - corner_ix_, from_bottom = iy - corner_iy_;
  if (from_left < 0 || from_left >= side_ || from_bottom < 0 || from_bottom >= side_) return nullptr;
  return &cells_[(iy & (side_ - 1)) * side_ + (ix & (side_ - 1))];
}

const SeenCells::State* SeenCells::at(double x, double y) const { return state(cell_of(x), cell_of(y)); }

bool SeenCells::is_seen(const State* cell, ScanNumber from) {
  return cell != nullptr && std::max(cell->last_free, cell->last_clear) >= from;
}

Mask SeenCells::unseen_blocks(double x, double y, Eigen::Index side, ScanNumber from) const {
  const std::int64_t left = cell_of(x + resolution / 2), bottom = cell_of(y + resolution / 2);
  const auto seen = [&](std::int64_t ix, std::int64_t iy) { return is_seen(state(ix, iy), from); };
  Mask unseen(side, side);
  for (Eigen::Index row = 0; row < side; ++row)
    for (Eigen::Index column = 0; column < side; ++column) {
      const std::int64_t ix = left + 2 * column, iy = bottom + 2 * row;
      unseen(row, column) = !seen(ix, iy) && !seen(ix + 1, iy) && !seen(ix, iy + 1) && !seen(ix + 1, iy + 1);
    }
  return unseen;
}

bool SeenCells::follow(double x, double y) {
  const std::int64_t old_x = std::exchange(corner_ix_, cell_of(x) - side_ / 2);
  const std::int64_t old_y = std::exchange(corner_iy_, cell_of(y) - side_ / 2);
  const std::int64_t dx = corner_ix_ - old_x, dy = corner_iy_ - old_y;
  if (dx == 0 && dy == 0) return false;
  const auto moved = [this](std::int64_t shift) { return std::clamp<std::int64_t>(shift, -side_, side_); };
  if (dx > 0) forget_columns(corner_ix_ + side_ - moved(dx), corner_ix_ + side_);
  if (dx < 0) forget_columns(corner_ix_, corner_ix_ - moved(dx));
  if (dy > 0) forget_rows(corner_iy_ + side_ - moved(dy), corner_iy_ + side_);
  if (dy < 0) forget_rows(corner_iy_, corner_iy_ - moved(dy));
  return true;
}

void SeenCells::forget_columns(std::int64_t from, std::int64_t to) {
  for (int iy = 0; iy < side_; ++iy)
    for (std::int64_t ix = from; ix < to; ++ix) cells_[iy * side_ + (ix & (side_ - 1))] = {};
}

void SeenCells::forget_rows(std::int64_t from, std::int64_t to) {
  for (std::int64_t iy = from; iy < to; ++iy)
    for (int ix = 0; ix < side_; ++ix) cells_[(iy & (side_ - 1)) * side_ + ix] = {};
}

void SeenCells::cross(double x, double y, double dx, double dy, double length, double sure, ScanNumber scan) {
  const double from_x = x / resolution - static_cast<double>(corner_ix_);
  const double from_y = y / resolution - static_cast<double>(corner_iy_);
  const double sure_until = sure / resolution + from_x * dx + from_y * dy - 0.5 * (dx + dy);
  walk_cells({from_x, from_y, dx, dy}, side_, side_, length / resolution, [&](Cell cell) {
    const std::int64_t ix = (corner_ix_ + cell.ix) & (side_ - 1), iy = (corner_iy_ + cell.iy) & (side_ - 1);
    State& passed = cells_[iy * side_ + ix];
    passed.last_free = scan;
    if (cell.ix * dx + cell.iy * dy > sure_until) return;  // the cell's centre lies beyond
    if (std::exchange(passed.last_clear, scan) != scan) ++passed.crossings;
  });
}

void SeenCells::hit(double x, double y) {
  if (State* struck = state(cell_of(x), cell_of(y))) struck->crossings = 0;
}

void SeenCells::cover(const Pose2& pose, const Footprint& body, ScanNumber scan) {
  const double radius = body.outer_radius(), c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  const std::int64_t right = cell_of(pose.x + radius), top = cell_of(pose.y + radius);
  for (std::int64_t iy = cell_of(pose.y - radius); iy <= top; ++iy) {
    for (std::int64_t ix = cell_of(pose.x - radius); ix <= right; ++ix) {
      const double x = (static_cast<double>(ix) + 0.5) * resolution - pose.x;
      const double y = (static_cast<double>(iy) + 0.5) * resolution - pose.y;
      const double ahead = c * x + s * y, left = -s * x + c * y;
      if (ahead > body.front || ahead < -body.rear || std::abs(left) > body.half_width) continue;
      if (State* under = state(ix, iy)) under->last_clear = scan;
    }
  }
}

bool SeenCells::surely_clear(std::int64_t ix, std::int64_t iy, ScanNumber from) const {
  const State* cell = state(ix, iy);
  return cell != nullptr && cell->last_clear >= from;
}

bool SeenCells::clear_around(double x, double y, ScanNumber from) const {
  const std::int64_t ix = cell_of(x), iy = cell_of(y);
  const State* here = state(ix, iy);
  if (here == nullptr || here->last_clear < from || here->crossings < sure_crossings) return false;
  constexpr int reach = static_cast<int>(neighbourhood / resolution);
  for (int dy = -reach; dy <= reach; ++dy)
    for (int dx = -reach; dx <= reach; ++dx) {
      if (dx * dx + dy * dy > reach * reach) continue;
      const std::int64_t cx = ix + dx, cy = iy + dy;
      if (!surely_clear(cx, cy, from) && !surely_clear(cx - 1, cy, from) && !surely_clear(cx + 1, cy, from) &&
          !surely_clear(cx, cy - 1, from) && !surely_clear(cx, cy + 1, from))
        return false;
    }
  return true;
}

}  // namespace lfdcore
