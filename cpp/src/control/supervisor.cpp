#include "lfdcore/control/supervisor.hpp"

#include <algorithm>
#include <limits>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

constexpr double longest_arc = 0.025;  // [s]: within it the twist is replaced by its mean (error < 2e-5 m)
constexpr double rounding = 1e-9;      // [m]

double stopping_distance(double speed, double reaction, const MotionLimits& limits) {
  return speed * reaction + speed * speed / (2 * limits.linear_braking);
}

// How far a graze between two tested poses may go unseen [m].
double tolerance(double margin) { return std::clamp(margin / 4, 2e-4, 2e-3); }

void require_finite_twist(const std::string& name, const Twist2& twist) {
  require_finite(name + " linear", twist.linear, "m/s");
  require_finite(name + " angular", twist.angular, "rad/s");
}

}  // namespace

void validate(const SupervisorConfig& config) {
  require_positive("period", config.period, "s");
  require_between("reaction", config.reaction, config.period, 10, "s");
  require_between("margin", config.margin, 0, 1, "m");
  require_between("slow_margin", config.slow_margin, 0, config.margin, "m");
  require_between("slow_linear", config.slow_linear, 0, 10, "m/s");
  require_between("slow_angular", config.slow_angular, 0, 10, "rad/s");
  require_between("overlap", config.overlap, 0, 1, "m");
  require_between("least_scale", config.least_scale, 0.01, 1, "");
  require_between("linear_samples", config.linear_samples, 2, 100, "");
  require_between("angular_samples", config.angular_samples, 2, 100, "");
}

Supervisor::Supervisor(const Footprint& footprint, const MotionLimits& limits, const SupervisorConfig& config)
    : footprint_(footprint), limits_(limits), config_(config) {
  validate(limits);
  validate(config);
  require_bounded(footprint);
  require_positive("footprint front", footprint.front, "m");
  require_positive("footprint rear", footprint.rear, "m");
  require_positive("footprint half_width", footprint.half_width, "m");
  const double fastest = std::max(limits.max_linear, limits.max_reverse);
  require_between("time to stop", fastest / limits.linear_braking, 0, 30, "s");
  require_between("time to stop turning", limits.max_angular / limits.angular_acceleration, 0, 30, "s");
}

SupervisorResult Supervisor::filter(const Twist2& wanted, const Twist2& current, const ObstaclePoints& obstacles) {
  require_finite_twist("wanted", wanted);
  require_finite_twist("current", current);
  const double fastest = std::max(limits_.max_linear, limits_.max_reverse);
  require_between("current linear", current.linear, -10 * fastest, 10 * fastest, "m/s");
  require_between("current angular", current.angular, -10 * limits_.max_angular, 10 * limits_.max_angular, "rad/s");

  const Twist2 aim{std::clamp(wanted.linear, -limits_.max_reverse, limits_.max_linear),
                   std::clamp(wanted.angular, -limits_.max_angular, limits_.max_angular)};
  current_ = current;
  const double speed = std::max(std::abs(aim.linear), std::abs(current.linear));
  const double axle_travel = stopping_distance(speed, config_.reaction, limits_);
  points_.gather(obstacles, axle_travel + footprint_.outer_radius() + config_.margin + rounding);
  clearance_ = points_.slack({}, footprint_);
  margin_ = std::numeric_limits<double>::quiet_NaN();

  Twist2 found;  // 0 unless something better is admissible
  if (admissible(aim)) {
    found = aim;
  } else if (!largest_scale(aim, found) && !nearest_twist(aim, found)) {
    margin_ = margin_for({});
  }
  SupervisorResult result{found, 1, false, false, margin_};
  result.changed = found.linear != wanted.linear || found.angular != wanted.angular;
  result.stopped = size(found) == 0 && size(wanted) > 0;
  if (size(wanted) > 0) result.scale = size(found) / size(wanted);
  return result;
}

double Supervisor::size(const Twist2& twist) const {
  return std::hypot(twist.linear / limits_.max_linear, twist.angular / limits_.max_angular);
}

double Supervisor::margin_for(const Twist2& command) const {
  const double linear = std::max(std::abs(command.linear), std::abs(current_.linear));
  const double angular = std::max(std::abs(command.angular), std::abs(current_.angular));
  const bool slow = linear <= config_.slow_linear && angular <= config_.slow_angular;
  const double margin = slow ? config_.slow_margin : config_.margin;
  return std::max(std::min(margin, clearance_), -config_.overlap);
}

bool Supervisor::admissible(const Twist2& command) {
  const double margin = margin_for(command);
  if (margin != margin_) points_.keep(margin, footprint_);
  margin_ = margin;
  for (const double follow : {config_.reaction, config_.period}) {
    roll_out(command, follow);
    if (!roll_out_is_free()) return false;
    if (config_.reaction == config_.period) break;
  }
  return true;
}

void Supervisor::roll_out(const Twist2& command, double follow) {
  arcs_.clear();
  const Twist2 at_braking = append(current_, command, follow);
  const double stopping = std::max(std::abs(at_braking.linear) / limits_.linear_braking,
                                   std::abs(at_braking.angular) / limits_.angular_acceleration);
  append(at_braking, {}, stopping);
  append({}, {}, 0);  // the standstill
}

Twist2 Supervisor::append(const Twist2& from, const Twist2& command, double duration) {
  Pose2 pose;
  double reach = 0;
  if (!arcs_.empty()) {
    const Arc& last = arcs_.back();
    pose = integrate(last.start, last.twist, last.duration);
    reach = reach_at(static_cast<double>(arcs_.size()));
  }
  const int count = std::max(1, static_cast<int>(std::ceil(duration / longest_arc - 1e-9)));
  const double step = duration / count;
  Twist2 twist = from;
  for (int i = 0; i < count; ++i) {
    const Twist2 next = approach(twist, command, limits_, step);
    const Twist2 mean{(twist.linear + next.linear) / 2, (twist.angular + next.angular) / 2};
    arcs_.push_back({pose, mean, step, reach});
    pose = integrate(pose, mean, step);
    reach += (std::abs(mean.linear) + std::abs(mean.angular) * footprint_.outer_radius()) * step;
    twist = next;
  }
  return twist;
}

// A place on the roll-out: number of the arc + share of it.
double Supervisor::reach_at(double place) const {
  const auto k = std::min(static_cast<std::size_t>(place), arcs_.size() - 1);
  const Arc& arc = arcs_[k];
  const double speed = std::abs(arc.twist.linear) + std::abs(arc.twist.angular) * footprint_.outer_radius();
  return arc.reach + speed * arc.duration * (place - static_cast<double>(k));
}

double Supervisor::slack_at(double place) {
  const auto k = std::min(static_cast<std::size_t>(place), arcs_.size() - 1);
  const Arc& arc = arcs_[k];
  const double time = arc.duration * (place - static_cast<double>(k));
  return points_.slack(integrate(arc.start, arc.twist, time), footprint_, -2 * rounding);
}

bool Supervisor::roll_out_is_free() {
  const double end = static_cast<double>(arcs_.size() - 1);
  const double slack_end = slack_at(end);
  if (slack_end < -rounding) return false;
  return free_between(0, end, slack_at(0), slack_end);
}

// The slack changes by no more than the reach, so it cannot get below 0 between two places whose slacks add up to more
// than the reach between them. Else look in the middle, down to moves that the tolerance covers.
bool Supervisor::free_between(double from, double to, double slack_from, double slack_to) {
  const double reach = reach_at(to) - reach_at(from);
  if (slack_from + slack_to > reach || reach <= 2 * tolerance(margin_)) return true;
  const double middle = (from + to) / 2;
  const double slack = slack_at(middle);
  if (slack < -rounding) return false;
  return free_between(from, middle, slack_from, slack) && free_between(middle, to, slack, slack_to);
}

// Scales on a grid from the top, since a faster one may be admissible where a slower one is not; then refined upwards.
bool Supervisor::largest_scale(const Twist2& wanted, Twist2& found) {
  constexpr int steps = 6, refinements = 3;
  const auto scaled = [&](double scale) { return Twist2{scale * wanted.linear, scale * wanted.angular}; };
  const double spacing = (1 - config_.least_scale) / steps;
  for (int i = 1; i <= steps; ++i) {
    double good = 1 - i * spacing;
    if (!admissible(scaled(good))) continue;
    double bad = good + spacing;
    double margin = margin_;
    for (int k = 0; k < refinements; ++k) {
      const double middle = (good + bad) / 2;
      const bool free = admissible(scaled(middle));
      (free ? good : bad) = middle;
      if (free) margin = margin_;
    }
    found = scaled(good);
    margin_ = margin;
    return true;
  }
  return false;
}

// Twists that 0 is farther away than lie within `size` of the wanted one: the grid spans just that.
void Supervisor::list_candidates(const Twist2& wanted) {
  candidates_.clear();
  const double farthest = size(wanted);
  const auto try_later = [&](double linear, double angular) {
    const double distance = size({wanted.linear - linear, wanted.angular - angular});
    if (distance < farthest && std::abs(angular) <= limits_.max_angular)
      candidates_.push_back({{linear, angular}, distance});
  };
  for (int i = 0; i < config_.linear_samples; ++i) {
    const double linear = wanted.linear * (1 - static_cast<double>(i) / (config_.linear_samples - 1));
    for (int j = 0; j < config_.angular_samples; ++j) {
      const double turn = limits_.max_angular * farthest * (2.0 * j / (config_.angular_samples - 1) - 1);
      try_later(linear, wanted.angular + turn);
    }
    try_later(linear, 0);  // along a wall that is too near for any turn
    if (wanted.linear == 0) break;
  }
  std::sort(candidates_.begin(), candidates_.end(),
            [](const Candidate& a, const Candidate& b) { return a.distance < b.distance; });
}

bool Supervisor::nearest_twist(const Twist2& wanted, Twist2& found) {
  list_candidates(wanted);
  for (const Candidate& candidate : candidates_) {
    if (!admissible(candidate.twist)) continue;
    found = candidate.twist;
    return true;
  }
  return false;
}

}  // namespace lfdcore
