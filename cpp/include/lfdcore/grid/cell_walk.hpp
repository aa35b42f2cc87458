// The cells that a straight line passes through, in order (Amanatides & Woo 1987).
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "lfdcore/grid/grid.hpp"

namespace lfdcore {

/// A half line in units of cells, cell (0, 0) at 0..1; the direction has unit length.
struct CellRay {
  double x, y, dx, dy;
};

/// The part [from, to] of a ray that lies in a box of width x height cells; from > to if none does.
struct RaySpan {
  double from, to;
};

inline RaySpan clip(const CellRay& ray, double width, double height, double length) {
  RaySpan span{0, length};
  const auto cut = [&span](double at, double direction, double size) {
    if (direction == 0) {
      if (!(at >= 0 && at < size)) span.to = -1;
      return;
    }
    const double a = -at / direction, b = (size - at) / direction;
    span.from = std::max(span.from, std::min(a, b));
    span.to = std::min(span.to, std::max(a, b));
  };
  cut(ray.x, ray.dx, width);
  cut(ray.y, ray.dy, height);
  return span;
}

/// Calls visit(Cell) for every cell of a width x height box that the ray's first `length` cells pass through.
template <class Visit>
void walk_cells(const CellRay& ray, int width, int height, double length, Visit visit) {
  const RaySpan span = clip(ray, width, height, length);
  if (!(span.from <= span.to)) return;
  const auto start = [&](double at, double direction, int size) {
    return static_cast<int>(std::clamp(at + span.from * direction, 0.0, size - 1.0));
  };
  const auto first_crossing = [](int cell, double at, double direction) {
    if (direction == 0) return std::numeric_limits<double>::infinity();
    return (cell + (direction > 0 ? 1 : 0) - at) / direction;
  };
  Cell cell{start(ray.x, ray.dx, width), start(ray.y, ray.dy, height)};
  double next_x = first_crossing(cell.ix, ray.x, ray.dx), next_y = first_crossing(cell.iy, ray.y, ray.dy);
  const double step_x = std::abs(1 / ray.dx), step_y = std::abs(1 / ray.dy);
  const int sign_x = ray.dx > 0 ? 1 : -1, sign_y = ray.dy > 0 ? 1 : -1;
  while (cell.ix >= 0 && cell.ix < width && cell.iy >= 0 && cell.iy < height) {
    visit(cell);
    if (std::min(next_x, next_y) > span.to) return;
    if (next_x < next_y) {
      cell.ix += sign_x;
      next_x += step_x;
    } else {
      cell.iy += sign_y;
      next_y += step_y;
    }
  }
}

}  // namespace lfdcore
