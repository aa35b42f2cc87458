#include "goal_distance.hpp"

namespace lfdcore {

bool GoalDistance::build(const ClearanceMap& map, const Eigen::Vector2d& goal, double tolerance, const DiscCost& disc) {
  weigh(map, disc);
  if (!seed(goal, tolerance)) return false;
  flood();
  return true;
}

// The border stays blocked, so that neighbours need no bounds.
void GoalDistance::weigh(const ClearanceMap& map, const DiscCost& disc) {
  const double half_diagonal = cell * std::numbers::sqrt2 / 2;
  std::fill(steps_.begin(), steps_.end(), blocked);
  for (int iy = 1; iy + 1 < side_; ++iy)
    for (int ix = 1; ix + 1 < side_; ++ix) {
      const double clearance = map.at_most(map.index(offset(ix)), map.index(offset(iy))) + half_diagonal - disc.radius;
      if (clearance < disc.margin) continue;
      const double lack = std::max(0.0, 1 - std::max(0.0, clearance) / disc.comfort);
      steps_[iy * side_ + ix] = unreached;
      factor_[iy * side_ + ix] = static_cast<float>(std::min<double>(dearest, 1 + disc.weight * lack * lack));
    }
}

bool GoalDistance::seed(const Eigen::Vector2d& goal, double tolerance) {
  for (auto& bucket : buckets_) bucket.clear();
  const double near = tolerance + cell * std::numbers::sqrt2 / 2;
  for (int iy = std::max(index(goal.y() - near), 1); iy <= std::min(index(goal.y() + near), side_ - 2); ++iy)
    for (int ix = std::max(index(goal.x() - near), 1); ix <= std::min(index(goal.x() + near), side_ - 2); ++ix)
      if (std::hypot(offset(ix) - goal.x(), offset(iy) - goal.y()) <= near) relax(iy * side_ + ix, 0);
  return !buckets_[0].empty();
}

void GoalDistance::relax(int at, int distance) {
  if (steps_[at] <= distance) return;
  steps_[at] = distance;
  buckets_[distance % buckets_.size()].push_back(at);
}

void GoalDistance::flood() {
  int idle = 0;
  for (int distance = 0; idle < static_cast<int>(buckets_.size()); ++distance) {
    auto& bucket = buckets_[distance % buckets_.size()];
    idle = bucket.empty() ? idle + 1 : 0;
    for (const int at : bucket) {
      if (steps_[at] != distance) continue;
      const int aside = static_cast<int>(straight * factor_[at]), across = static_cast<int>(diagonal * factor_[at]);
      for (const int next : {at - 1, at + 1, at - side_, at + side_}) relax(next, distance + aside);
      for (const int next : {at - side_ - 1, at - side_ + 1, at + side_ - 1, at + side_ + 1})
        relax(next, distance + across);
    }
    bucket.clear();
  }
}

double GoalDistance::at(double x, double y) const {
  const int steps = steps_[std::clamp(index(y), 0, side_ - 1) * side_ + std::clamp(index(x), 0, side_ - 1)];
  if (steps == blocked || steps == unreached) return std::numeric_limits<double>::infinity();
  // A way of 10s and 14s is at most hypot(1, 0.4) times as long as the straight one; both ends lie within half a
  // diagonal of their cells' centres.
  return std::max(0.0, steps * cell / straight / std::hypot(1.0, 0.4) - cell * std::numbers::sqrt2);
}

}  // namespace lfdcore
