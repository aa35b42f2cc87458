#include "lfdcore/control/near_points.hpp"

#include <limits>

#include "../vectorised.hpp"

namespace lfdcore {

constexpr std::size_t lanes = 8, chunk = 64;
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double hair = 1e-4;  // [m]: ranges of 32 bits are rounded
constexpr double sway = 1e-3;  // [m] by which a turn that dies away may bring nearer what is beside a side now

// Of some points in a row.
struct Columns {
  const double *x, *y, *uncertainty, *most, *passing, *least_passing;
};

// Lowers least[k] to the least slack of the points in lane k. A minimum for each lane, so that the compiler may
// vectorise without reordering a floating-point reduction.
LFDCORE_CLONES void lower_slack(const Columns& points, std::size_t count, const Demand& demand, const double* pose,
                                const double* body, double* least) {
  const double *x = points.x, *y = points.y, *uncertainty = points.uncertainty;
  const double *most = points.most, *passing = points.passing, *least_passing = points.least_passing;
  const double required = demand.required, sideways = demand.sideways;
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
      const double wanted = required + uncertainty[i + k];
      const double keep = wanted < most[i + k] ? wanted : most[i + k], beside = passing[i + k] - sideways;
      const double passed = beside >= least_passing[i + k] && beside < keep ? beside : keep;
      const double slack = std::sqrt(ox * ox + oy * oy) + (inner < 0 ? inner : 0) - passed;
      least[k] = slack < least[k] ? slack : least[k];
    }
  }
}

void NearPoints::make_room(std::size_t points) {
  const std::size_t room = points + lanes;
  if (x_.size() < room) {
    for (auto* column : {&x_, &y_, &uncertainty_, &most_, &passing_, &least_passing_}) column->resize(room);
  }
  count_ = last_hit_ = 0;
}

void NearPoints::append(double x, double y, double uncertainty, double most) {
  x_[count_] = x;
  y_[count_] = y;
  uncertainty_[count_] = uncertainty;
  passing_[count_] = -infinity;
  least_passing_[count_] = 0;
  most_[count_++] = most;
}

void NearPoints::pad() {
  const std::size_t count = count_;
  while (count_ < count + lanes) append(1e9, 1e9, 0, 0);
  count_ = count;
}

void NearPoints::gather(const ObstaclePoints& obstacles, double radius) {
  const Path& points = obstacles.points();
  make_room(static_cast<std::size_t>(points.rows()));
  const double* row = points.data();
  for (Eigen::Index i = 0; i < points.rows(); ++i, row += 2) {
    if (row[0] * row[0] + row[1] * row[1] <= radius * radius) append(row[0], row[1], 0, infinity);
  }
  pad();
}

void NearPoints::gather(const ObstaclePoints& obstacles, double radius, const Footprint& footprint) {
  const Path& points = obstacles.points();
  make_room(static_cast<std::size_t>(points.rows()));
  const double* row = points.data();
  for (const double uncertainty : obstacles.uncertainty()) {
    const double reach = radius + uncertainty;
    if (row[0] * row[0] + row[1] * row[1] <= reach * reach)
      append(row[0], row[1], uncertainty, signed_distance(row[0], row[1], footprint));
    row += 2;
  }
  pad();
}

// Without branches, so that the compiler vectorises it.
LFDCORE_CLONES void find_passing(std::size_t count, const double* y, const double* uncertainty, const double* most,
                                 double half_width, double margin, double* passing, double* least_passing) {
  for (std::size_t i = 0; i < count; ++i) {
    const double beside = std::abs(y[i]) - half_width;
    const double clear = beside >= margin - hair ? uncertainty[i] - hair : infinity;
    const double swayed = most[i] == beside ? beside - sway : infinity;
    const double least = clear < swayed ? clear : swayed;
    passing[i] = beside >= least ? beside : -infinity;
    least_passing[i] = least;
  }
}

void NearPoints::let_pass(const Footprint& footprint, double margin, Sides& sides) {
  find_passing(count_, y_.data(), uncertainty_.data(), most_.data(), footprint.half_width, margin, passing_.data(),
               least_passing_.data());
  if (look_at(sides, footprint, margin)) let_pass_along(sides, footprint);
}

bool NearPoints::look_at(Sides& sides, const Footprint& footprint, double margin) const {
  bool may_touch[] = {false, false};
  for (auto& ways : sides)
    for (SideContact& way : ways) way.look();
  for (std::size_t i = 0; i < count_; ++i) {
    const double beside = std::abs(y_[i]) - footprint.half_width, unsure = uncertainty_[i];
    if (!SideContact::may_belong(beside, unsure)) continue;
    const bool right = y_[i] < 0;
    if (x_[i] <= footprint.front) sides[right][0].add(x_[i], beside);
    if (x_[i] >= -footprint.rear) sides[right][1].add(x_[i], beside);
    if (is_beside(i, beside) && beside < margin + unsure) may_touch[right] = true;
  }
  const double span = (footprint.front + footprint.rear) / 2;
  for (int right = 0; right < 2; ++right)
    for (SideContact& way : sides[right]) way.measure(span, may_touch[right]);
  return may_touch[0] || may_touch[1];
}

void NearPoints::let_pass_along(const Sides& sides, const Footprint& footprint) {
  for (std::size_t i = 0; i < count_; ++i) {
    const double beside = std::abs(y_[i]) - footprint.half_width;
    if (beside >= SideContact::near) continue;
    const double least = sides[y_[i] < 0][x_[i] < 0].least(uncertainty_[i]);
    if (beside < least) continue;
    passing_[i] = beside;
    least_passing_[i] = std::min(least_passing_[i], least);
  }
}

double NearPoints::slack(const Pose2& pose, const Footprint& footprint, const Demand& demand, double enough) {
  const double at[] = {pose.x, pose.y, std::cos(pose.yaw), std::sin(pose.yaw)};
  const double body[] = {footprint.front, footprint.rear, footprint.half_width};
  double lane[lanes];
  double least = infinity;
  std::fill(lane, lane + lanes, least);
  const std::size_t chunks = (count_ + chunk - 1) / chunk;
  // What stopped the last pose will often stop this one: begin there.
  for (std::size_t k = 0, at_chunk = last_hit_; k < chunks; ++k, at_chunk = at_chunk + 1 < chunks ? at_chunk + 1 : 0) {
    const std::size_t i = at_chunk * chunk;
    const Columns columns{x_.data() + i,    y_.data() + i,       uncertainty_.data() + i,
                          most_.data() + i, passing_.data() + i, least_passing_.data() + i};
    lower_slack(columns, std::min(chunk, count_ - i), demand, at, body, lane);
    least = *std::min_element(lane, lane + lanes);
    if (least <= enough) {
      last_hit_ = at_chunk;
      break;
    }
  }
  return least;
}

}  // namespace lfdcore
