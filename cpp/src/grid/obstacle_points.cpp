#include "lfdcore/grid/obstacle_points.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "../vectorised.hpp"
#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

constexpr double finest_cell = 0.05;    // [m]
constexpr double most_cells = 1 << 16;  // wider clouds of points get larger cells
constexpr int gap_limit = 11;           // [cells] gaps are measured up to here, so that sums of squares fit a byte
constexpr int gap_square = gap_limit * gap_limit;
constexpr double slack = 1e-6;  // [m] by which searches reach farther than rounding can err

[[noreturn]] void refuse(const Pose2& pose) {
  require_finite("pose x", pose.x, "m");
  require_finite("pose y", pose.y, "m");
  require_finite("pose yaw", pose.yaw, "rad");
  throw std::invalid_argument("footprint is not finite [m]");
}

// An empty list becomes one of zeros.
void require_one_each(std::vector<double>& uncertainty, Eigen::Index points) {
  const auto count = static_cast<std::size_t>(points);
  if (uncertainty.empty()) uncertainty.resize(count);
  if (uncertainty.size() != count) {
    throw std::invalid_argument("uncertainty has " + std::to_string(uncertainty.size()) + " values, must have 0 or " +
                                std::to_string(count) + ", one a point");
  }
  for (const double u : uncertainty) require_between("uncertainty", u, 0, 100, "m");
}

// A body's outline at its pose.
struct Body {
  double x, y, c, s;
  const Footprint& f;

  Body(const Pose2& pose, const Footprint& footprint)
      : x(pose.x), y(pose.y), c(std::cos(pose.yaw)), s(std::sin(pose.yaw)), f(footprint) {
    if (!std::isfinite(pose.x + pose.y + pose.yaw + f.front + f.rear + f.half_width)) refuse(pose);
  }

  // Squared distance from a point to the rectangle; 0 inside.
  double squared_distance(const Eigen::Vector2d& point) const {
    const double dx = point.x() - x, dy = point.y() - y;
    const double ahead = c * dx + s * dy, left = -s * dx + c * dy;
    const double beyond = std::max({ahead - f.front, -f.rear - ahead, 0.0});
    const double beside = std::max(std::abs(left) - f.half_width, 0.0);
    return beyond * beyond + beside * beside;
  }
};

// The rectangle cut across, each section in a circle, its gap thresholds in squared cells.
struct Sections {
  static constexpr int most = 8;
  const Footprint& f;
  int count = 1;
  double half_length, cells_per_metre, outside_from;

  Sections(const Footprint& footprint, double scale) : f(footprint), cells_per_metre(scale) {
    const double length = f.front + f.rear;
    while (count < most && count * f.half_width < length) ++count;
    half_length = length / count / 2;
    outside_from = (half_length * half_length + f.half_width * f.half_width) * (1 + slack) * scale * scale + 1e-9;
  }

  double centre(int i) const { return f.front - (2 * i + 1) * half_length; }

  // A gap g means a point within g + 2 sqrt(2) cells: inside, if the largest disc around the section's centre holds it.
  double inside_until(int i) const {
    const double radius = std::min({f.half_width, (2 * i + 1) * half_length, (2 * (count - i) - 1) * half_length});
    const double cells = radius * cells_per_metre - 2.83;
    return cells > 0 ? std::min(cells * cells, gap_square - 1.0) : -1;
  }
};

// In place: distance in rows to the nearest 0 of the same column. Rows run through all columns at once.
LFDCORE_CLONES void measure_along_columns(std::uint8_t* cells, int width, int height) {
  for (int iy = 1; iy < height; ++iy) {
    std::uint8_t* here = cells + static_cast<std::ptrdiff_t>(iy) * width;
    const std::uint8_t* below = here - width;
    for (int ix = 0; ix < width; ++ix) here[ix] = std::min<std::uint8_t>(here[ix], below[ix] + 1);
  }
  for (int iy = height - 2; iy >= 0; --iy) {
    std::uint8_t* here = cells + static_cast<std::ptrdiff_t>(iy) * width;
    const std::uint8_t* above = here + width;
    for (int ix = 0; ix < width; ++ix) here[ix] = std::min<std::uint8_t>(here[ix], above[ix] + 1);
  }
}

// row[ix] = min over k of padded[ix + k] + gap(k)^2, where gap(k) = |k| - 1 is what lies between two cells at least.
LFDCORE_CLONES void measure_along_row(const std::uint8_t* padded, std::uint8_t* row, int width) {
  for (int ix = 0; ix < width; ++ix) row[ix] = padded[ix + gap_limit];
  for (int k = -gap_limit; k <= gap_limit; ++k) {
    const int gap = std::max(std::abs(k) - 1, 0);
    const auto square = static_cast<std::uint8_t>(gap * gap);
    const std::uint8_t* shifted = padded + gap_limit + k;
    for (int ix = 0; ix < width; ++ix)
      row[ix] = std::min<std::uint8_t>(row[ix], static_cast<std::uint8_t>(shifted[ix] + square));
  }
}

}  // namespace

ObstaclePoints::ObstaclePoints(Path points, std::vector<double> uncertainty)
    : points_(std::move(points)), uncertainty_(std::move(uncertainty)) {
  require(points_.allFinite(), "obstacle points must be finite [m]");
  require_one_each(uncertainty_, points_.rows());
  if (points_.rows() == 0) return;
  lay_out_cells();
  sort_into_buckets();
  measure_gaps();
}

void ObstaclePoints::lay_out_cells() {
  const Eigen::Vector2d low = points_.colwise().minCoeff(), high = points_.colwise().maxCoeff();
  const double wide = high.x() - low.x(), tall = high.y() - low.y();
  require(std::isfinite(wide) && std::isfinite(tall), "obstacle points are too far apart to measure [m]");
  const double cell =
      std::max({finest_cell, std::sqrt(wide) * std::sqrt(tall / most_cells), (wide + tall) / most_cells});
  cells_per_metre_ = 1 / cell;
  corner_x_ = low.x();
  corner_y_ = low.y();
  width_ = static_cast<int>(wide * cells_per_metre_) + 1;
  height_ = static_cast<int>(tall * cells_per_metre_) + 1;
  bucket_columns_ = (width_ + 1) / 2;
  bucket_rows_ = (height_ + 1) / 2;
}

int ObstaclePoints::column(double x) const {
  return static_cast<int>(std::clamp((x - corner_x_) * cells_per_metre_, 0.0, width_ - 1.0));
}

int ObstaclePoints::row(double y) const {
  return static_cast<int>(std::clamp((y - corner_y_) * cells_per_metre_, 0.0, height_ - 1.0));
}

// Whether a gap was measured right here; beyond the cells, theirs are only lower bounds.
bool ObstaclePoints::covers(double x, double y) const {
  const double column = (x - corner_x_) * cells_per_metre_, row = (y - corner_y_) * cells_per_metre_;
  return column >= 0 && column < width_ && row >= 0 && row < height_;
}

void ObstaclePoints::sort_into_buckets() {
  const Eigen::Index count = points_.rows();
  std::vector<std::uint32_t> bucket(count);
  first_.assign(static_cast<std::size_t>(bucket_columns_) * bucket_rows_ + 1, 0);
  for (Eigen::Index i = 0; i < count; ++i) {
    bucket[i] = (row(points_(i, 1)) / 2) * bucket_columns_ + column(points_(i, 0)) / 2;
    ++first_[bucket[i] + 1];
  }
  for (std::size_t b = 1; b < first_.size(); ++b) first_[b] += first_[b - 1];
  sorted_.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) sorted_[first_[bucket[i]]++] = points_.row(i);
  std::copy_backward(first_.begin(), first_.end() - 1, first_.end());
  first_[0] = 0;
}

void ObstaclePoints::measure_gaps() {
  gaps_.assign(static_cast<std::size_t>(width_) * height_, gap_limit + 1);
  for (Eigen::Index i = 0; i < points_.rows(); ++i)
    gaps_[static_cast<std::size_t>(row(points_(i, 1))) * width_ + column(points_(i, 0))] = 0;
  measure_along_columns(gaps_.data(), width_, height_);
  std::vector<std::uint8_t> padded(width_ + 2 * gap_limit, gap_square);
  for (int iy = 0; iy < height_; ++iy) {
    std::uint8_t* cells = gaps_.data() + static_cast<std::size_t>(iy) * width_;
    for (int ix = 0; ix < width_; ++ix) {
      const int gap = std::max(cells[ix] - 1, 0);
      padded[ix + gap_limit] = static_cast<std::uint8_t>(gap * gap);
    }
    measure_along_row(padded.data(), cells, width_);
  }
}

ObstaclePoints::Buckets ObstaclePoints::buckets_around(double x, double y, double half_x, double half_y) const {
  return {column(x - half_x) / 2, column(x + half_x) / 2, row(y - half_y) / 2, row(y + half_y) / 2};
}

bool ObstaclePoints::all_buckets(const Buckets& b) const {
  return b.left == 0 && b.bottom == 0 && b.right == bucket_columns_ - 1 && b.top == bucket_rows_ - 1;
}

template <class Visit>
bool ObstaclePoints::any_point(const Buckets& b, Visit visit) const {
  for (int by = b.bottom; by <= b.top; ++by) {
    const std::uint32_t* row_first = first_.data() + static_cast<std::size_t>(by) * bucket_columns_;
    const std::uint32_t end = row_first[b.right + 1];
    for (std::uint32_t i = row_first[b.left]; i < end; ++i)
      if (visit(sorted_[i])) return true;
  }
  return false;
}

// The rectangle is cut across into sections about as long as half its width. A section whose circumscribed circle is
// free according to the gaps holds no point; a disc inside the rectangle that must hold one decides as well; for the
// sections that are left, the points near by are tested exactly.
bool ObstaclePoints::collides(const Pose2& pose, const Footprint& footprint) const {
  const Body body(pose, footprint);
  if (sorted_.empty()) return false;
  const Sections cut(footprint, cells_per_metre_);
  int unsure[Sections::most];
  int count = 0;
  for (int i = 0; i < cut.count; ++i) {
    const double ahead = cut.centre(i), x = body.x + body.c * ahead, y = body.y + body.s * ahead;
    const double gap = gaps_[static_cast<std::size_t>(row(y)) * width_ + column(x)];
    if (gap > cut.outside_from) continue;
    if (gap <= cut.inside_until(i) && covers(x, y)) return true;
    unsure[count++] = i;
  }
  const double half_x = std::abs(body.c) * cut.half_length + std::abs(body.s) * footprint.half_width + slack;
  const double half_y = std::abs(body.s) * cut.half_length + std::abs(body.c) * footprint.half_width + slack;
  for (int k = 0; k < count; ++k) {
    const double ahead = cut.centre(unsure[k]), x = body.x + body.c * ahead, y = body.y + body.s * ahead;
    if (any_point(buckets_around(x, y, half_x, half_y),
                  [&](const Eigen::Vector2d& p) { return body.squared_distance(p) <= 0; }))
      return true;
  }
  return false;
}

// Searches boxes around the body that grow until they must hold the nearest point.
double ObstaclePoints::clearance(const Pose2& pose, const Footprint& footprint) const {
  const Body body(pose, footprint);
  double nearest = std::numeric_limits<double>::infinity();
  if (sorted_.empty()) return nearest;
  const double half = (footprint.front + footprint.rear) / 2, middle = (footprint.front - footprint.rear) / 2;
  const double half_x = std::abs(body.c * half) + std::abs(body.s * footprint.half_width);
  const double half_y = std::abs(body.s * half) + std::abs(body.c * footprint.half_width);
  for (double reach = 0.25;; reach *= 2) {
    const Buckets box = buckets_around(body.x + body.c * middle, body.y + body.s * middle, half_x + reach + slack,
                                       half_y + reach + slack);
    any_point(box, [&](const Eigen::Vector2d& p) {
      nearest = std::min(nearest, body.squared_distance(p));
      return nearest <= 0;
    });
    if (nearest <= reach * reach || all_buckets(box)) return std::sqrt(nearest);
  }
}

}  // namespace lfdcore
