#include "lfdcore/control/supervisor.hpp"

#include <algorithm>
#include <limits>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double rounding = 1e-9;          // [m]
constexpr double longest_prospect = 10.0;  // [s]: of pending commands, and of the points' age

// How far a graze between two tested poses may go unseen [m]: of the 2 mm that are promised, the rest is for what lies
// between the courses that are rolled out.
double tolerance(double margin) { return std::clamp(margin / 4, 2e-4, 1.5e-3); }

void require_finite_twist(const std::string& name, const Twist2& twist) {
  require_finite(name + " linear", twist.linear, "m/s");
  require_finite(name + " angular", twist.angular, "rad/s");
}

bool between(double value, double a, double b) { return std::min(a, b) <= value && value <= std::max(a, b); }

}  // namespace

void validate(const SupervisorConfig& config) {
  require_between("margin", config.margin, 0, 1, "m");
  require_between("least_margin", config.least_margin, 0, config.margin, "m");
  require_between("passing_margin", config.passing_margin, 0, config.least_margin, "m");
  require_between("margin_linear", config.margin_linear, 0.01, 10, "m/s");
  require_between("margin_angular", config.margin_angular, 0.01, 10, "rad/s");
  require_between("dynamics_error", config.dynamics_error, 0, 0.9, "");
  require_between("speed_error", config.speed_error, 0, 0.9, "");
  require_between("obstacle_speed", config.obstacle_speed, 0, 10, "m/s");
  require_between("walking_speed", config.walking_speed, 0, 10, "m/s");
  require_between("creep_linear", config.creep_linear, 0, 10, "m/s");
  require_between("creep_reverse", config.creep_reverse, 0, 10, "m/s");
  require_between("creep_angular", config.creep_angular, 0, 10, "rad/s");
  require_between("least_scale", config.least_scale, 0.01, 1, "");
  require_between("linear_samples", config.linear_samples, 2, 100, "");
  require_between("angular_samples", config.angular_samples, 2, 100, "");
}

Supervisor::Supervisor(const Footprint& footprint, const MotionLimits& limits, const SupervisorConfig& config,
                       const CommandTiming& timing)
    : footprint_(footprint),
      limits_(limits),
      config_(config),
      timing_(timing),
      rollouts_(limits, {config.dynamics_error, config.speed_error}) {
  validate(limits);
  validate(config);
  validate(timing);
  require_bounded(footprint);
  require_positive("footprint front", footprint.front, "m");
  require_positive("footprint rear", footprint.rear, "m");
  require_positive("footprint half_width", footprint.half_width, "m");
  const double fastest = std::max(limits.max_linear, limits.max_reverse), quick = 1 - config.dynamics_error;
  require_between("time to stop", fastest / limits.linear_braking / quick, 0, 30, "s");
  require_between("time to stop turning", limits.max_angular / limits.angular_acceleration / quick, 0, 30, "s");
}

void Supervisor::require_valid(const Twist2& wanted, const Twist2& current, std::span<const TimedTwist> pending,
                               double age) const {
  const double fastest = 10 * std::max(limits_.max_linear, limits_.max_reverse), turn = 10 * limits_.max_angular;
  require_finite_twist("wanted", wanted);
  require_between("current linear", current.linear, -fastest, fastest, "m/s");
  require_between("current angular", current.angular, -turn, turn, "rad/s");
  double sum = 0;
  for (const TimedTwist& command : pending) {
    require_between("pending linear", command.twist.linear, -fastest, fastest, "m/s");
    require_between("pending angular", command.twist.angular, -turn, turn, "rad/s");
    require_between("pending duration", command.duration, 0, longest_prospect, "s");
    sum += command.duration;
  }
  require_between("sum of pending durations", sum, 0, longest_prospect, "s");
  require_between("age", age, 0, longest_prospect, "s");
}

void Supervisor::reset() {
  for (auto& ways : sides_)
    for (SideContact& way : ways) way.let_go();
}

SupervisorResult Supervisor::filter(const Twist2& wanted, const Twist2& current, const ObstaclePoints& obstacles,
                                    std::span<const TimedTwist> pending, double age, const ObstaclePoints& unseen,
                                    const ObstaclePoints& walkers) {
  require_valid(wanted, current, pending, age);
  const Twist2 aim{std::clamp(wanted.linear, -limits_.max_reverse, limits_.max_linear),
                   std::clamp(wanted.angular, -limits_.max_angular, limits_.max_angular)};
  age_ = age;
  look(aim, current, obstacles, pending, unseen, walkers);

  Twist2 found = aim;
  bool keeps = admissible(aim) || largest_scale(aim, found) || nearest_twist(aim, found);
  if (!keeps) {
    found = {};
    keeps = admissible(found);
  }
  SupervisorResult result{found, 1, false, false, keeps, margin_for(found)};
  result.changed = found.linear != wanted.linear || found.angular != wanted.angular;
  result.stopped = size(found) == 0 && size(wanted) > 0;
  if (size(wanted) > 0) result.scale = size(found) / size(wanted);
  return result;
}

// Takes the points that any roll-out of this call may come near to.
void Supervisor::look(const Twist2& aim, const Twist2& current, const ObstaclePoints& obstacles,
                      std::span<const TimedTwist> pending, const ObstaclePoints& unseen,
                      const ObstaclePoints& walkers) {
  fastest_linear_ = std::abs(current.linear);
  fastest_angular_ = std::abs(current.angular);
  double following = timing_.period + timing_.jitter;
  for (const TimedTwist& command : pending) {
    fastest_linear_ = std::max(fastest_linear_, std::abs(command.twist.linear));
    fastest_angular_ = std::max(fastest_angular_, std::abs(command.twist.angular));
    following += command.duration;
  }
  const double speed = std::max(fastest_linear_, std::abs(aim.linear));
  const double turn = std::max(fastest_angular_, limits_.max_angular);
  const double stopping = speed / (limits_.linear_braking * (1 - config_.dynamics_error));
  const double turning = turn / (limits_.angular_acceleration * (1 - config_.dynamics_error));
  const double travel = speed * (1 + config_.speed_error) * (following + stopping / 2);
  const double until_standstill = age_ + following + std::max(stopping, turning);
  const double reach = travel + footprint_.outer_radius() + rounding;
  points_.gather(obstacles, reach + config_.margin + config_.obstacle_speed * until_standstill, footprint_);
  if (size(aim) == 0) reset();
  points_.let_pass(footprint_, config_.passing_margin, sides_);
  unseen_.gather(unseen, reach, footprint_);
  walkers_.gather(walkers, reach + config_.margin + config_.walking_speed * until_standstill, footprint_);
  rollouts_.start(current, pending);
}

// The size of the stick that asks for a twist: 1 at the limit of one speed.
double Supervisor::size(const Twist2& twist) const {
  const double full = twist.linear < 0 ? limits_.max_reverse : limits_.max_linear;
  return std::hypot(twist.linear / full, twist.angular / limits_.max_angular);
}

bool Supervisor::may_replace(const Twist2& wanted, const Twist2& twist) const {
  if (!between(twist.linear, 0, wanted.linear)) return false;
  if (wanted.linear == 0) return between(twist.angular, 0, wanted.angular);
  if (twist.angular * wanted.angular < 0 || std::abs(twist.angular) > limits_.max_angular) return false;
  const double full = wanted.linear < 0 ? -limits_.max_reverse : limits_.max_linear;
  const double linear = (wanted.linear - twist.linear) / full;
  const double angular = (wanted.angular - twist.angular) / limits_.max_angular;
  return size(twist) <= size(wanted) * (1 + 1e-12) && std::hypot(linear, angular) < size(wanted);
}

double Supervisor::margin_for(const Twist2& command) const {
  const double linear = std::max(std::abs(command.linear), fastest_linear_) / config_.margin_linear;
  const double angular = std::max(std::abs(command.angular), fastest_angular_) / config_.margin_angular;
  const double share = std::min(std::max(linear, angular), 1.0);
  return config_.least_margin + share * (config_.margin - config_.least_margin);
}

bool Supervisor::creeps(const Twist2& command) const {
  return between(command.linear, -config_.creep_reverse, config_.creep_linear) &&
         std::abs(command.angular) <= config_.creep_angular;
}

// The share of the wanted twist that creeps.
double Supervisor::creep_scale(const Twist2& wanted) const {
  if (wanted.linear == 0) return config_.creep_angular / std::abs(wanted.angular);
  return (wanted.linear < 0 ? config_.creep_reverse : config_.creep_linear) / std::abs(wanted.linear);
}

bool Supervisor::admissible(const Twist2& command) {
  rollouts_.end_with(command, timing_.period, timing_.jitter);
  const double until_standstill = age_ + rollouts_.duration(), margin = margin_for(command);
  const bool creeping = creeps(command);
  // A chair beside a wall that is too near for any turn gets out straight ahead, slowly.
  const double sideways = rollouts_.turning() * (footprint_.outer_radius() + rollouts_.travel());
  const Demand demand{margin + config_.obstacle_speed * until_standstill,
                      creeping && command.angular == 0 ? sideways : infinity};
  if (!stays_clear_of(points_, demand)) return false;
  if (walkers_.size() > 0 && !stays_clear_of(walkers_, {margin + config_.walking_speed * until_standstill}))
    return false;
  return unseen_.size() == 0 || creeping || stays_clear_of(unseen_, {});
}

// The roll-outs, and what lies between their ends.
bool Supervisor::stays_clear_of(NearPoints& points, const Demand& demand) {
  points_tested_ = &points;
  demand_ = demand;
  for (int i = 0; i < rollouts_.count(); ++i) {
    arcs_ = &rollouts_.arcs(i);
    measure_reach();
    ends_[i] = {arcs_->back().start, slack_at(arcs_->back().start)};
    if (ends_[i].slack < -rounding) return false;
    if (!free_along({0, slack_at({})}, {static_cast<double>(arcs_->size() - 1), ends_[i].slack})) return false;
  }
  if (rollouts_.count() == 2) return free_across(ends_[0], ends_[1]);
  if (rollouts_.count() < 4) return true;
  return free_across(ends_[0], ends_[1]) && free_across(ends_[2], ends_[3]) && free_across(ends_[0], ends_[2]) &&
         free_across(ends_[1], ends_[3]);
}

void Supervisor::measure_reach() {
  reach_.clear();
  double reach = 0;
  for (const RolloutArc& arc : *arcs_) {
    reach_.push_back(reach);
    reach += (std::abs(arc.twist.linear) + std::abs(arc.twist.angular) * footprint_.outer_radius()) * arc.duration;
  }
}

double Supervisor::reach_at(double place) const {
  const auto k = static_cast<std::size_t>(place);
  if (k + 1 >= reach_.size()) return reach_.back();
  return reach_[k] + (reach_[k + 1] - reach_[k]) * (place - static_cast<double>(k));
}

double Supervisor::slack_at(const Pose2& pose) {
  return points_tested_->slack(pose, footprint_, demand_, -2 * rounding);
}

Pose2 Supervisor::pose_at(double place) const {
  const auto k = static_cast<std::size_t>(place);
  const RolloutArc& arc = (*arcs_)[k];
  return integrate(arc.start, arc.twist, arc.duration * (place - static_cast<double>(k)));
}

// The slack changes by no more than the body moves, so it cannot get below 0 between two poses whose slacks add up to
// more than the way between them. Else look in the middle, down to moves that the tolerance covers.
bool Supervisor::free_along(const Place& from, const Place& to) {
  const double way = reach_at(to.number) - reach_at(from.number);
  if (from.slack + to.slack > way || way <= 2 * tolerance(demand_.required)) return true;
  const double number = (from.number + to.number) / 2;
  const Place middle{number, slack_at(pose_at(number))};
  return middle.slack >= -rounding && free_along(from, middle) && free_along(middle, to);
}

bool Supervisor::free_across(const End& from, const End& to) {
  const double dx = to.pose.x - from.pose.x, dy = to.pose.y - from.pose.y;
  const double turn = wrap_angle(to.pose.yaw - from.pose.yaw);
  const double way = std::hypot(dx, dy) + std::abs(turn) * footprint_.outer_radius();
  if (from.slack + to.slack > way || way <= 2 * tolerance(demand_.required)) return true;
  const Pose2 pose{from.pose.x + dx / 2, from.pose.y + dy / 2, from.pose.yaw + turn / 2};
  const End middle{pose, slack_at(pose)};
  return middle.slack >= -rounding && free_across(from, middle) && free_across(middle, to);
}

// From an admissible twist towards another one, as far as it stays admissible.
Twist2 Supervisor::refined(Twist2 good, Twist2 bad) {
  for (int k = 0; k < 3; ++k) {
    const Twist2 middle{(good.linear + bad.linear) / 2, (good.angular + bad.angular) / 2};
    (admissible(middle) ? good : bad) = middle;
  }
  return good;
}

// Scales on a grid from the top, since a faster one may be admissible where a slower one is not.
bool Supervisor::largest_scale(const Twist2& wanted, Twist2& found) {
  constexpr int steps = 3;
  const auto scaled = [&](double scale) { return Twist2{scale * wanted.linear, scale * wanted.angular}; };
  const double spacing = (1 - config_.least_scale) / steps;
  for (int i = 1; i <= steps; ++i) {
    const double scale = 1 - i * spacing;
    if (!admissible(scaled(scale))) continue;
    found = refined(scaled(scale), scaled(scale + spacing));
    return true;
  }
  return false;
}

void Supervisor::try_later(const Twist2& wanted, const Twist2& twist) {
  if (!may_replace(wanted, twist)) return;
  const double full = wanted.linear < 0 ? limits_.max_reverse : limits_.max_linear;
  const double linear = (wanted.linear - twist.linear) / full;
  candidates_.push_back({twist, std::hypot(linear, (wanted.angular - twist.angular) / limits_.max_angular)});
}

// The grid spans what may replace the wanted twist. Besides: straight on, along a wall that is too near for any turn;
// and the same arc.
void Supervisor::list_candidates(const Twist2& wanted) {
  candidates_.clear();
  const double span = limits_.max_angular * size(wanted);
  const auto try_at_scale = [&](double scale) {
    const double linear = scale * wanted.linear;
    try_later(wanted, {linear, scale * wanted.angular});
    if (wanted.linear == 0) return;
    try_later(wanted, {linear, 0});
    for (int j = 0; j < config_.angular_samples; ++j) {
      try_later(wanted, {linear, wanted.angular + span * (2.0 * j / (config_.angular_samples - 1) - 1)});
    }
  };
  const int last = config_.linear_samples - 1;
  for (int i = 0; i <= last; ++i) try_at_scale(1 - static_cast<double>(i) / last);
  try_at_scale(0.5 / last);
  try_at_scale(std::min(creep_scale(wanted), 1.0));
  std::sort(candidates_.begin(), candidates_.end(),
            [](const Candidate& a, const Candidate& b) { return a.distance < b.distance; });
}

bool Supervisor::nearest_twist(const Twist2& wanted, Twist2& found) {
  list_candidates(wanted);
  for (const Candidate& candidate : candidates_) {
    if (!admissible(candidate.twist)) continue;
    found = refined(candidate.twist, wanted);
    return true;
  }
  return false;
}

}  // namespace lfdcore
