#include "lfdcore/control/near_points.hpp"

#include <limits>

#include "../vectorised.hpp"

namespace lfdcore {

constexpr std::size_t lanes = 8, chunk = 64;

// Lowers least[k] to the least slack of the points in lane k. A minimum for each lane, so that the compiler may
// vectorise without reordering a floating-point reduction.
LFDCORE_CLONES void lower_slack(const double* x, const double* y, const double* keep, std::size_t count,
                                const double* pose, const double* body, double* least) {
  const double px = pose[0], py = pose[1], c = pose[2], s = pose[3];
  const double front = body[0], rear = body[1], half_width = body[2];
  for (std::size_t i = 0; i < count; i += lanes) {
    for (std::size_t k = 0; k < lanes; ++k) {
      const double dx = x[i + k] - px, dy = y[i + k] - py;
      const double bx = c * dx + s * dy, by = c * dy - s * dx;
      const double ahead = bx - front, behind = -rear - bx;
      const double beyond_x = ahead > behind ? ahead : behind;
      const double beyond_y = std::abs(by) - half_width;
      const double ox = beyond_x > 0 ? beyond_x : 0, oy = beyond_y > 0 ? beyond_y : 0;
      const double inner = beyond_x > beyond_y ? beyond_x : beyond_y;
      const double slack = std::sqrt(ox * ox + oy * oy) + (inner < 0 ? inner : 0) - keep[i + k];
      least[k] = slack < least[k] ? slack : least[k];
    }
  }
}

void NearPoints::gather(const ObstaclePoints& obstacles, double radius) {
  const Path& points = obstacles.points();
  const auto room = static_cast<std::size_t>(points.rows()) + lanes;
  if (x_.size() < room) {
    x_.resize(room);
    y_.resize(room);
    keep_.resize(room);
  }
  count_ = last_hit_ = 0;
  const double* row = points.data();
  for (Eigen::Index i = 0; i < points.rows(); ++i, row += 2) {
    x_[count_] = row[0];
    y_[count_] = row[1];
    keep_[count_] = 0;
    count_ += row[0] * row[0] + row[1] * row[1] <= radius * radius ? 1 : 0;
  }
  for (std::size_t i = count_; i < std::min(count_ + lanes, room); ++i) {
    x_[i] = y_[i] = 1e9;
    keep_[i] = 0;
  }
}

void NearPoints::keep(double distance, const Footprint& footprint) {
  for (std::size_t i = 0; i < count_; ++i) {
    keep_[i] = std::min(distance, signed_distance(x_[i], y_[i], footprint));
  }
}

double NearPoints::slack(const Pose2& pose, const Footprint& footprint, double enough) {
  const double at[] = {pose.x, pose.y, std::cos(pose.yaw), std::sin(pose.yaw)};
  const double body[] = {footprint.front, footprint.rear, footprint.half_width};
  double lane[lanes];
  double least = std::numeric_limits<double>::infinity();
  std::fill(lane, lane + lanes, least);
  const std::size_t chunks = (count_ + chunk - 1) / chunk;
  // What stopped the last pose will often stop this one: begin there.
  for (std::size_t k = 0, at_chunk = last_hit_; k < chunks; ++k, at_chunk = at_chunk + 1 < chunks ? at_chunk + 1 : 0) {
    const std::size_t i = at_chunk * chunk;
    lower_slack(x_.data() + i, y_.data() + i, keep_.data() + i, std::min(chunk, count_ - i), at, body, lane);
    least = *std::min_element(lane, lane + lanes);
    if (least <= enough) {
      last_hit_ = at_chunk;
      break;
    }
  }
  return least;
}

}  // namespace lfdcore
