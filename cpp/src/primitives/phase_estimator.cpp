#include "lfdcore/primitives/phase_estimator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

constexpr std::size_t capacity = 512;
constexpr double never = -std::numeric_limits<double>::infinity();

double median(std::span<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2) return *middle;
  return (*middle + *std::max_element(values.begin(), middle)) / 2;
}

}  // namespace

void validate(const PhaseEstimatorConfig& config) {
  require_positive("phase_decay", config.phase_decay, "");
  require_positive("tempo_window", config.tempo_window, "s");
  require_between("tempo_window", config.tempo_window, 0, 60, "s");
  require(config.rest_share > 0 && config.rest_share < 1,
          "rest_share is " + std::to_string(config.rest_share) + ", must be within (0, 1)");
  require(config.pause_rate >= 0 && config.pause_rate < 1,
          "pause_rate is " + std::to_string(config.pause_rate) + ", must be within [0, 1)");
}

PhaseEstimator::PhaseEstimator(const RowMatrix& reference, double duration, const PhaseEstimatorConfig& config)
    : config_(config), dtw_(reference), duration_(duration), start_(static_cast<std::size_t>(dtw_.dimensions())) {
  validate(config);
  require_positive("duration", duration, "s");
  require(size() > 1, "reference has 1 sample, must have 2 at least");
  const Eigen::VectorXd gone = (reference.rowwise() - reference.row(0)).rowwise().norm();
  rest_distance_ = config.rest_share * gone.maxCoeff();
  require(rest_distance_ > 0, "reference never leaves its start: it has no phase");
  while (gone[first_moving_] <= rest_distance_) ++first_moving_;
  for (auto* ring : {&stamps_, &times_, &scratch_}) ring->resize(capacity);
  reset();
}

void PhaseEstimator::reset() {
  dtw_.reset();
  first_stamp_ = last_stamp_ = never;
  std::fill(start_.begin(), start_.end(), std::numeric_limits<double>::quiet_NaN());
  left_start_ = false;
  oldest_ = held_ = 0;
  phase_ = {};
}

const PartnerPhase& PhaseEstimator::observe(double stamp, std::span<const double> sample) {
  if (!(std::isfinite(stamp) && stamp > last_stamp_))
    throw std::invalid_argument("stamp is " + std::to_string(stamp) + " s, must be later than " +
                                std::to_string(last_stamp_) + " s, the last sample's");
  const OpenEndPhase found = dtw_.observe(sample);
  last_stamp_ = stamp;
  if (std::all_of(sample.begin(), sample.end(), [](double x) { return std::isnan(x); })) return phase_;
  if (first_stamp_ == never) first_stamp_ = stamp;
  left_start_ = has_left_start(sample) || left_start_;
  const double share = static_cast<double>(found.index) / (size() - 1);
  phase_.index = found.index;
  phase_.distance = found.distance;
  phase_.reference_time = share * duration_;
  phase_.phase = std::exp(-config_.phase_decay * share);  // 5.5 (ERRATA 38)
  phase_.determined = phase_.determined || (left_start_ && found.index >= first_moving_);
  if (!phase_.determined) return phase_;
  phase_.mean_rate = phase_.reference_time / (stamp - first_stamp_);  // F14
  remember(stamp, phase_.reference_time);
  if (stamp - stamps_[oldest_] < config_.tempo_window / 2 || held_ < 3) return phase_;
  phase_.rate = std::max(0.0, slope());
  phase_.paused = phase_.rate < config_.pause_rate;
  return phase_;
}

bool PhaseEstimator::has_left_start(std::span<const double> sample) {
  double squared = 0;
  for (std::size_t d = 0; d < sample.size(); ++d) {
    if (std::isnan(sample[d])) continue;
    if (std::isnan(start_[d])) start_[d] = sample[d];
    squared += (sample[d] - start_[d]) * (sample[d] - start_[d]);
  }
  return squared > rest_distance_ * rest_distance_;
}

void PhaseEstimator::remember(double stamp, double reference_time) {
  const auto drop = [&] { oldest_ = (oldest_ + 1) % capacity, --held_; };
  if (held_ == capacity) drop();
  while (held_ > 0 && stamps_[oldest_] < stamp - config_.tempo_window) drop();
  const std::size_t at = (oldest_ + held_++) % capacity;
  stamps_[at] = stamp;
  times_[at] = reference_time;
}

double PhaseEstimator::slope() {
  const std::size_t third = std::max<std::size_t>(1, held_ / 3);
  const auto median_of = [&](const std::vector<double>& ring, std::size_t first) {
    for (std::size_t i = 0; i < third; ++i) scratch_[i] = ring[(oldest_ + first + i) % capacity];
    return median({scratch_.data(), third});
  };
  return (median_of(times_, held_ - third) - median_of(times_, 0)) /
         (median_of(stamps_, held_ - third) - median_of(stamps_, 0));
}

}  // namespace lfdcore
