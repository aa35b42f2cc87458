#include "lfdcore/control/dynamic_window.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include "lfdcore/control/near_points.hpp"
#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

constexpr double same_cost = 1e-9;  // [m]: all turns on the spot cost the same but for rounding

struct Candidate {
  double cost = 0;      // in whole steps of same_cost
  double distance = 0;  // from the wanted twist
  int index = 0;
  // For a heap whose top is the cheapest; ties go to the twist nearer to the wanted one.
  bool operator<(const Candidate& other) const {
    return std::tie(cost, distance, index) > std::tie(other.cost, other.distance, other.index);
  }
};

// The extreme twists that one period of acceleration reaches, both ways.
struct Window {
  Twist2 low, high;
};

Window reachable_window(const Twist2& current, const MotionLimits& limits, double period) {
  return {approach(current, {-limits.max_reverse, -limits.max_angular}, limits, period),
          approach(current, {limits.max_linear, limits.max_angular}, limits, period)};
}

double sample(double low, double high, int i, int count) {
  return count == 1 ? (low + high) / 2 : low + (high - low) * i / (count - 1);
}

Twist2 twist_at(const Window& window, int index, const DynamicWindowConfig& config) {
  const int i = index / config.angular_samples, j = index % config.angular_samples;
  return {sample(window.low.linear, window.high.linear, i, config.linear_samples),
          sample(window.low.angular, window.high.angular, j, config.angular_samples)};
}

Eigen::Vector2d end_of(const Twist2& twist, double duration) {
  const Pose2 end = integrate({}, twist, duration);
  return {end.x, end.y};
}

// Tests the poses at every step, leaving out those that the clearance so far shows to be free.
bool collides(NearPoints& points, const Footprint& footprint, const Twist2& twist, const DynamicWindowConfig& config) {
  const int steps = static_cast<int>(std::ceil(config.horizon / config.step - 1e-9));
  const double fastest = std::abs(twist.linear) + std::abs(twist.angular) * footprint.outer_radius();
  const double move = fastest * config.step;  // no point of the body moves farther in a step
  for (int k = 1; k <= steps;) {
    const double time = std::min(k * config.step, config.horizon);
    const double clearance = points.slack(integrate({}, twist, time), footprint, {}, 0);
    if (clearance <= 0) return true;
    if (clearance >= move * (steps - k)) return false;
    k += std::max(1, static_cast<int>(clearance / move * (1 - 1e-9)));
  }
  return false;
}

double farthest_reach(const Window& window, const Footprint& footprint, double horizon) {
  const double speed = std::max(std::abs(window.low.linear), std::abs(window.high.linear));
  return speed * horizon + footprint.outer_radius() + 1e-6;
}

void rank_candidates(std::vector<Candidate>& heap, const Window& window, const Eigen::Vector2d& goal,
                     const Twist2& wanted, const DynamicWindowConfig& config) {
  heap.resize(static_cast<std::size_t>(config.linear_samples) * config.angular_samples);
  for (int j = 0; j < config.angular_samples; ++j) {
    // All speeds of one turning rate end on one ray.
    const Eigen::Vector2d end_at_1 = end_of({1, twist_at(window, j, config).angular}, config.horizon);
    for (int i = 0; i < config.linear_samples; ++i) {
      const int index = i * config.angular_samples + j;
      const Twist2 twist = twist_at(window, index, config);
      const double cost = std::round((twist.linear * end_at_1 - goal).norm() / same_cost);
      heap[index] = {cost, std::hypot(twist.linear - wanted.linear, twist.angular - wanted.angular), index};
    }
  }
  std::make_heap(heap.begin(), heap.end());
}

DynamicWindowResult braking(const Twist2& current, const MotionLimits& limits, double period, double horizon) {
  const Twist2 twist = approach(current, {}, limits, period);
  return {twist, false, end_of(twist, horizon), std::numeric_limits<double>::infinity()};
}

}  // namespace

void validate(const DynamicWindowConfig& config) {
  require_between("linear_samples", config.linear_samples, 1, 1000, "");
  require_between("angular_samples", config.angular_samples, 1, 1000, "");
  require_positive("horizon", config.horizon, "s");
  require_positive("step", config.step, "s");
  require_between("step", config.step, config.horizon / 10000, config.horizon, "s");
}

DynamicWindowResult solve_dynamic_window(const Twist2& current, const Eigen::Vector2d& goal,
                                         const ObstaclePoints& obstacles, const Footprint& footprint,
                                         const MotionLimits& limits, const DynamicWindowConfig& config,
                                         const Twist2& wanted, double period) {
  require_bounded(footprint);
  validate(config);
  validate(limits);
  require_finite("current linear", current.linear, "m/s");
  require_finite("current angular", current.angular, "rad/s");
  require_finite("goal x", goal.x(), "m");
  require_finite("goal y", goal.y(), "m");
  require_finite("wanted linear", wanted.linear, "m/s");
  require_finite("wanted angular", wanted.angular, "rad/s");
  require_positive("period", period, "s");

  thread_local NearPoints points;
  thread_local std::vector<Candidate> heap;
  const Window window = reachable_window(current, limits, period);
  points.gather(obstacles, farthest_reach(window, footprint, config.horizon));
  rank_candidates(heap, window, goal, wanted, config);

  // Alg. 8 keeps the cheapest of all twists. Taken cheapest first, the first that does not collide is that one.
  for (auto last = heap.end(); last != heap.begin(); --last) {
    std::pop_heap(heap.begin(), last);
    const Candidate best = *(last - 1);
    const Twist2 twist = twist_at(window, best.index, config);
    if (!collides(points, footprint, twist, config)) {
      const Eigen::Vector2d end = end_of(twist, config.horizon);
      return {twist, true, end, (end - goal).norm()};
    }
  }
  return braking(current, limits, period, config.horizon);
}

}  // namespace lfdcore
