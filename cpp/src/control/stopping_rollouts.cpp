#include "lfdcore/control/stopping_rollouts.hpp"

#include <algorithm>
#include <numeric>

namespace lfdcore {
namespace {

constexpr double longest_step = 0.05;  // [s]: within it the twist is replaced by its mean (error < 5e-5 m)

// Goes on with the highest course of a speed; -> the distance made. Speeding up and slowing down take turns at 0.
double advance_highest(double& speed, double target, double speeding_up, double slowing_down, double error,
                       double duration) {
  double distance = 0;
  while (duration > 0 && speed != target) {
    const bool rising = target > speed, slowing = rising ? speed < 0 : speed > 0;
    const double until = !slowing ? target : rising ? std::min(target, 0.0) : std::max(target, 0.0);
    const double rate = (slowing ? slowing_down : speeding_up) * (rising ? 1 + error : 1 - error);
    const double time = std::min(duration, std::abs(until - speed) / rate);
    const double next = time < duration ? until : speed + std::copysign(rate * time, until - speed);
    distance += (speed + next) / 2 * time;
    duration -= time;
    speed = next;
  }
  return distance + speed * duration;
}

double with_error(double speed, double error) { return speed * (speed > 0 ? 1 + error : 1 - error); }

}  // namespace

void StoppingRollouts::Band::cut_to(std::size_t steps) {
  highest.resize(steps);
  lowest.resize(steps);
}

bool StoppingRollouts::Band::is_one_sided() const {
  return std::all_of(lowest.begin(), lowest.end(), [](double speed) { return speed >= 0; }) ||
         std::all_of(highest.begin(), highest.end(), [](double speed) { return speed <= 0; });
}

bool StoppingRollouts::Band::is_at_rest() const {
  const auto still = [](double speed) { return speed == 0; };
  return std::all_of(highest.begin(), highest.end(), still) && std::all_of(lowest.begin(), lowest.end(), still);
}

void StoppingRollouts::start(const Twist2& current, std::span<const TimedTwist> pending) {
  steps_.clear();
  linear_.cut_to(0);
  angular_.cut_to(0);
  linear_.high = linear_.low = current.linear;
  angular_.high = angular_.low = current.angular;
  for (const TimedTwist& command : pending) follow(command.twist, command.twist, command.duration);
  started_ = steps_.size();
  started_low_ = {linear_.low, angular_.low};
  started_high_ = {linear_.high, angular_.high};
}

void StoppingRollouts::end_with(const Twist2& command, double duration, double jitter) {
  steps_.resize(started_);
  linear_.cut_to(started_);
  angular_.cut_to(started_);
  linear_.low = started_low_.linear;
  linear_.high = started_high_.linear;
  angular_.low = started_low_.angular;
  angular_.high = started_high_.angular;
  follow(command, command, duration);
  // The command or, already, 0:
  follow({std::min(command.linear, 0.0), std::min(command.angular, 0.0)},
         {std::max(command.linear, 0.0), std::max(command.angular, 0.0)}, jitter);
  follow({}, {}, time_to_stop());
  choose();
}

double StoppingRollouts::time_to_stop() const {
  const double linear = std::max(std::abs(linear_.low), std::abs(linear_.high)) / limits_.linear_braking;
  const double angular = std::max(std::abs(angular_.low), std::abs(angular_.high)) / limits_.angular_acceleration;
  return std::max(linear, angular) / (1 - errors_.dynamics);
}

double StoppingRollouts::duration() const { return std::accumulate(steps_.begin(), steps_.end(), 0.0); }

double StoppingRollouts::most(const Band& band) const {
  double sum = 0;
  for (std::size_t k = 0; k < steps_.size(); ++k)
    sum += std::max(std::abs(band.highest[k]), std::abs(band.lowest[k])) * steps_[k];
  return sum;
}

void StoppingRollouts::follow(const Twist2& low, const Twist2& high, double duration) {
  const int count = static_cast<int>(std::ceil(duration / longest_step - 1e-9));
  for (int i = 0; i < count; ++i) {
    const double step = duration / count;
    steps_.push_back(step);
    advance(linear_, {limits_.linear_acceleration, limits_.linear_braking}, low.linear, high.linear, step);
    advance(angular_, {limits_.angular_acceleration, limits_.angular_acceleration}, low.angular, high.angular, step);
  }
}

// The lowest course is the highest one seen in a mirror.
void StoppingRollouts::advance(Band& band, const Rates& rates, double low, double high, double duration) const {
  const auto distance = [&](double& speed, double target) {
    return advance_highest(speed, target, rates.speeding_up, rates.slowing_down, errors_.dynamics, duration);
  };
  band.highest.push_back(with_error(distance(band.high, high) / duration, errors_.speed));
  double mirrored = -band.low;
  band.lowest.push_back(-with_error(distance(mirrored, -low) / duration, errors_.speed));
  band.low = -mirrored;
}

// The farthest first, since it is refused most often. What another one holds is left out.
void StoppingRollouts::choose() {
  const auto courses = [](const Band& band, const Band& other) {
    double sum = 0;
    for (std::size_t k = 0; k < band.highest.size(); ++k) sum += band.highest[k] + band.lowest[k];
    const double *far = band.highest.data(), *near = band.lowest.data();
    if (sum < 0) std::swap(far, near);
    const bool one = band.is_one_course() || (other.is_at_rest() && band.is_one_sided());
    return std::pair{std::array{far, near}, one ? 1 : 2};
  };
  const auto [linear, linear_count] = courses(linear_, angular_);
  const auto [angular, angular_count] = courses(angular_, linear_);
  count_ = 0;
  for (int i = 0; i < linear_count; ++i) {
    for (int j = 0; j < angular_count; ++j) chosen_[count_++] = {linear[i], angular[j]};
  }
}

const std::vector<RolloutArc>& StoppingRollouts::arcs(int i) {
  arcs_.clear();
  Pose2 pose;
  const auto [linear, angular] = chosen_[i];
  for (std::size_t k = 0; k < steps_.size(); ++k) {
    arcs_.push_back({pose, {linear[k], angular[k]}, steps_[k]});
    pose = integrate(pose, arcs_.back().twist, steps_[k]);
  }
  arcs_.push_back({pose, {}, 0});
  return arcs_;
}

}  // namespace lfdcore
