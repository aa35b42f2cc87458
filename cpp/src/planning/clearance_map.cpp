#include "clearance_map.hpp"

namespace lfdcore {
namespace {

constexpr std::uint16_t far = ClearanceMap::reach;
constexpr std::uint16_t far_squared = far * far;

}  // namespace

ClearanceMap::ClearanceMap(double half_width)
    : cells_(2 * static_cast<int>(std::ceil(half_width / resolution)) + 1),
      squared_(static_cast<std::size_t>(cells_) * cells_),
      padded_(static_cast<std::size_t>(cells_) + 2 * far, far) {}

void ClearanceMap::build(const ObstaclePoints& obstacles, const Eigen::Vector2d& middle) {
  middle_ = middle;
  std::fill(squared_.begin(), squared_.end(), far);
  const double half_width = resolution * cells_ / 2;
  for (Eigen::Index i = 0; i < obstacles.points().rows(); ++i) {
    const double x = obstacles.points()(i, 0) - middle.x(), y = obstacles.points()(i, 1) - middle.y();
    if (std::abs(x) >= half_width || std::abs(y) >= half_width) continue;
    const int ix = index(x), iy = index(y);
    if (contains(ix, iy)) squared_[iy * cells_ + ix] = 0;
  }
  spread_along_columns();
  spread_along_rows();
}

void ClearanceMap::spread_along_columns() {
  const auto grow = [this](int to, int from) {
    for (int ix = 0; ix < cells_; ++ix) {
      const auto next = static_cast<std::uint16_t>(squared_[from * cells_ + ix] + 1);
      squared_[to * cells_ + ix] = std::min(squared_[to * cells_ + ix], next);
    }
  };
  for (int iy = 1; iy < cells_; ++iy) grow(iy, iy - 1);
  for (int iy = cells_ - 2; iy >= 0; --iy) grow(iy, iy + 1);
}

void ClearanceMap::spread_along_rows() {
  for (int iy = 0; iy < cells_; ++iy) {
    std::uint16_t* row = &squared_[iy * cells_];
    std::copy(row, row + cells_, padded_.begin() + far);
    std::fill(row, row + cells_, far_squared);
    for (int shift = -far; shift <= far; ++shift) {
      const std::uint16_t* from = &padded_[far + shift];
      const auto across = static_cast<std::uint16_t>(shift * shift);
      for (int ix = 0; ix < cells_; ++ix) {
        const auto sum = static_cast<std::uint16_t>(from[ix] * from[ix] + across);
        row[ix] = std::min(row[ix], sum);
      }
    }
  }
}

double ClearanceMap::at_least(double x, double y) const {
  const double dx = x - middle_.x(), dy = y - middle_.y();
  const double to_border = resolution * cells_ / 2 - std::max(std::abs(dx), std::abs(dy));
  if (!(to_border > 0)) return 0;
  const int ix = std::min(index(dx), cells_ - 1), iy = std::min(index(dy), cells_ - 1);
  // Both the point and the obstacle lie within half a diagonal of their cells' centres.
  return std::min(to_border, distance(std::max(ix, 0), std::max(iy, 0)) - resolution * std::numbers::sqrt2);
}

double ClearanceMap::at_most(int ix, int iy) const { return distance(ix, iy) + resolution * std::numbers::sqrt2 / 2; }

}  // namespace lfdcore
