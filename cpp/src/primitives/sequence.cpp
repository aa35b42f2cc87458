#include "lfdcore/primitives/sequence.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "lfdcore/error.hpp"
#include "lfdcore/primitives/dtw.hpp"
#include "series_checks.hpp"

namespace lfdcore {
namespace {

constexpr double impossible = -std::numeric_limits<double>::infinity();

double log_sum(std::span<const double> terms) {
  const double top = *std::max_element(terms.begin(), terms.end());
  if (top == impossible) return impossible;
  double sum = 0;
  for (const double term : terms) sum += std::exp(term - top);
  return top + std::log(sum);
}

double log_sum(double a, double b) { return log_sum(std::array{a, b}); }

void require_share(const char* name, double value, bool with_0, bool with_1) {
  require((with_0 ? value >= 0 : value > 0) && (with_1 ? value <= 1 : value < 1),
          std::string(name) + " is " + std::to_string(value) + ", must be within " + (with_0 ? "[" : "(") + "0, 1" +
              (with_1 ? "]" : ")"));
}

// ln P(k), k = 0..: pause or a Poisson number with a mean that makes `mean` of both, cut 8 deviations above it and at
// the last step, which takes what lies beyond.
std::vector<double> advances(double mean, int steps, double pause) {
  const double moving = mean / (1 - pause);
  const int last = std::min(steps - 1, static_cast<int>(std::ceil(moving + 8 * std::sqrt(moving) + 2)));
  std::vector<double> log_p(static_cast<std::size_t>(last) + 1);
  for (int k = 0; k <= last; ++k)
    log_p[static_cast<std::size_t>(k)] = std::log1p(-pause) + k * std::log(moving) - moving - std::lgamma(k + 1.0);
  if (pause > 0) log_p[0] = log_sum(log_p[0], std::log(pause));
  const double all = log_sum(log_p);
  for (double& value : log_p) value -= all;
  return log_p;
}

// (S, D): the demonstration at the phases s / (S - 1), linear in between.
RowMatrix stretched(const RowMatrix& demonstration, int steps) {
  RowMatrix result(steps, demonstration.cols());
  for (int s = 0; s < steps; ++s) {
    const double at = static_cast<double>(s) * static_cast<double>(demonstration.rows() - 1) / (steps - 1);
    const auto low = std::min(static_cast<Eigen::Index>(at), demonstration.rows() - 2);
    const double share = at - static_cast<double>(low);
    result.row(s) = (1 - share) * demonstration.row(low) + share * demonstration.row(low + 1);
  }
  return result;
}

// Variance of what is spread evenly over half the way to either neighbour.
RowMatrix extent_variance(const RowMatrix& mean) {
  RowMatrix result(mean.rows(), mean.cols());
  for (Eigen::Index s = 0; s < mean.rows(); ++s) {
    const auto before = std::max<Eigen::Index>(s - 1, 0), after = std::min(s + 1, mean.rows() - 1);
    result.row(s) = ((mean.row(after) - mean.row(before)) / static_cast<double>(after - before)).array().square() / 12;
  }
  return result;
}

// (S, D): at each step of `mean` the average of what DTW finds to correspond to it, so that a demonstration's tempo
// does not count. Distances are shares of the range.
RowMatrix aligned(const RowMatrix& demonstration, const RowMatrix& mean, const Eigen::RowVectorXd& range) {
  const int steps = static_cast<int>(mean.rows());
  const Eigen::VectorXd scale = range.cwiseInverse();
  const RowMatrix fine = stretched(demonstration, 4 * steps);
  RowMatrix sum = RowMatrix::Zero(steps, mean.cols());
  Eigen::VectorXd count = Eigen::VectorXd::Zero(steps);
  const WarpingPath path = dtw(fine * scale.asDiagonal(), mean * scale.asDiagonal()).path;
  for (const auto& pair : path.rowwise()) {
    sum.row(pair[1]) += fine.row(pair[0]);
    count[pair[1]] += 1;
  }
  return count.cwiseInverse().asDiagonal() * sum;
}

SequencePrimitive fit_primitive(const std::vector<RowMatrix>& demonstrations, const Eigen::RowVectorXd& range,
                                const SequenceConfig& config) {
  const auto count = static_cast<double>(demonstrations.size());
  RowMatrix mean = RowMatrix::Zero(config.phase_steps, range.size()), variance = mean;
  double samples = 0;
  for (const RowMatrix& one : demonstrations) {
    mean += stretched(one, config.phase_steps) / count;
    samples += static_cast<double>(one.rows()) / count;
  }
  std::vector<RowMatrix> all;
  for (const RowMatrix& one : demonstrations) all.push_back(aligned(one, mean, range));
  mean.setZero();
  for (const RowMatrix& one : all) mean += one / count;
  for (const RowMatrix& one : all) variance += (one - mean).cwiseAbs2() / std::max(1.0, count - 1);
  const Eigen::RowVectorXd average = variance.colwise().mean();
  const Eigen::RowVectorXd least = (config.least_deviation * range).cwiseAbs2();
  variance = config.widening / 2 * (variance.rowwise() + average) + extent_variance(mean);
  return {mean, variance.cwiseMax(least.replicate(config.phase_steps, 1)), samples};
}

// (D,) what all samples of all demonstrations extend over.
Eigen::RowVectorXd checked_range(const std::vector<std::vector<RowMatrix>>& demonstrations) {
  require(!demonstrations.empty(), "there are no primitives, must be one at least");
  Eigen::RowVectorXd low, high;
  for (std::size_t p = 0; p < demonstrations.size(); ++p) {
    require(!demonstrations[p].empty(), "primitive " + std::to_string(p) + " has no demonstrations");
    for (std::size_t i = 0; i < demonstrations[p].size(); ++i) {
      const RowMatrix& one = demonstrations[p][i];
      const std::string name = "demonstration " + std::to_string(i) + " of primitive " + std::to_string(p);
      detail::require_series(name, one);
      require(one.rows() > 1, name + " has 1 sample, must have 2 at least");
      if (low.size() == 0) low = high = one.row(0);
      require(one.cols() == low.size(),
              name + " has " + std::to_string(one.cols()) + " dimensions, the first " + std::to_string(low.size()));
      low = low.cwiseMin(one.colwise().minCoeff());
      high = high.cwiseMax(one.colwise().maxCoeff());
    }
  }
  for (Eigen::Index d = 0; d < low.size(); ++d)
    require(high[d] > low[d], "dimension " + std::to_string(d) + " is the same in all samples of all demonstrations");
  return high - low;
}

void check(const SequencePrimitive& primitive, Eigen::Index dimensions, const SequenceConfig& config,
           const std::string& name) {
  const auto fits = [&](const RowMatrix& m) { return m.rows() == config.phase_steps && m.cols() == dimensions; };
  require(fits(primitive.mean) && fits(primitive.variance), name + "'s mean and variance must both be (" +
                                                                std::to_string(config.phase_steps) + ", " +
                                                                std::to_string(dimensions) + ")");
  detail::require_series(name + "'s mean", primitive.mean);
  detail::require_series(name + "'s variance", primitive.variance);
  require((primitive.variance.array() > 0).all(), name + "'s variance must be > 0");
  require_between(name + "'s samples", primitive.samples, 2, 1e9, "");
}

}  // namespace

void validate(const SequenceConfig& config) {
  require_between("phase_steps", config.phase_steps, 2, 1000, "");
  require_share("pause", config.pause, true, false);
  require_share("finish", config.finish, false, true);
  require_share("chain", config.chain, true, true);
  require_share("abandon", config.abandon, true, false);
  require_share("start", config.start, true, true);
  require_share("none_prior", config.none_prior, true, false);
  require_positive("background_width", config.background_width, "");
  require_positive("widening", config.widening, "");
  require_positive("least_deviation", config.least_deviation, "");
}

SequenceHmm::SequenceHmm(std::vector<SequencePrimitive> primitives, Eigen::VectorXd background_density,
                         const SequenceConfig& config)
    : primitives_(std::move(primitives)), background_density_(std::move(background_density)), config_(config) {
  validate(config);
  require(!primitives_.empty(), "there are no primitives, must be one at least");
  require(background_density_.size() > 0 && (background_density_.array() > 0).all() && background_density_.allFinite(),
          "background_density must be > 0 and finite");
  std::size_t longest = 0;
  for (const SequencePrimitive& primitive : primitives_) {
    check(primitive, dimensions(), config, "primitive " + std::to_string(log_advances_.size()));
    log_advances_.push_back(
        advances((config.phase_steps - 1) / (primitive.samples - 1), config.phase_steps, config.pause));
    longest = std::max(longest, log_advances_.back().size());
  }
  const auto count = static_cast<Eigen::Index>(primitives_.size());
  log_alpha_.resize(count, config.phase_steps);
  predicted_ = belief_.steps = log_alpha_;
  belief_.probabilities.resize(count);
  belief_.progress.resize(count);
  terms_.resize(longest);
  reset();
}

SequenceHmm SequenceHmm::fit(const std::vector<std::vector<RowMatrix>>& demonstrations, const SequenceConfig& config) {
  validate(config);
  const Eigen::RowVectorXd range = checked_range(demonstrations);
  std::vector<SequencePrimitive> primitives;
  for (const auto& of_primitive : demonstrations) primitives.push_back(fit_primitive(of_primitive, range, config));
  return {std::move(primitives), (config.background_width * range).cwiseInverse(), config};
}

void SequenceHmm::reset() {
  const auto count = static_cast<double>(primitives_.size());
  begun_ = false;
  log_alpha_.setConstant(impossible);
  log_alpha_.col(0).setConstant(std::log((1 - config_.none_prior) / count));
  log_none_ = std::log(config_.none_prior);
  belief_.log_likelihood = 0;
  summarise();
}

const SequenceBelief& SequenceHmm::observe(std::span<const double> sample) {
  if (static_cast<int>(sample.size()) != dimensions())
    throw std::invalid_argument("sample has " + std::to_string(sample.size()) + " dimensions, the primitives " +
                                std::to_string(dimensions()));
  detail::require_sample(sample.data(), dimensions());
  if (begun_) predict();
  begun_ = true;
  weigh(sample);
  summarise();
  return belief_;
}

// alpha_t|t-1 = T' alpha_t-1
void SequenceHmm::predict() {
  const auto count = log_alpha_.rows(), last = log_alpha_.cols() - 1;
  double finished = impossible, abandoned = impossible;
  for (Eigen::Index p = 0; p < count; ++p) {
    finished = log_sum(finished, log_alpha_(p, last));
    abandoned = log_sum(abandoned, log_sum({log_alpha_.row(p).data(), static_cast<std::size_t>(last)}));
    advance(p);
  }
  finished += std::log(config_.finish);
  const double begins = log_sum(finished + std::log(config_.chain), log_none_ + std::log(config_.start)) -
                        std::log(static_cast<double>(count));
  for (Eigen::Index p = 0; p < count; ++p) predicted_(p, 0) = log_sum(predicted_(p, 0), begins);
  log_none_ = log_sum(log_none_ + std::log1p(-config_.start),
                      log_sum(finished + std::log1p(-config_.chain), abandoned + std::log(config_.abandon)));
  log_alpha_.swap(predicted_);
}

// Within primitive p; its last step takes all advances to it or beyond.
void SequenceHmm::advance(Eigen::Index p) {
  const auto& log_p = log_advances_[static_cast<std::size_t>(p)];
  const auto last = log_alpha_.cols() - 1, reach = static_cast<Eigen::Index>(log_p.size()) - 1;
  const double stays = std::log1p(-config_.abandon);
  for (Eigen::Index s = 0; s < last; ++s) {
    const Eigen::Index most = std::min(reach, s);
    for (Eigen::Index k = 0; k <= most; ++k)
      terms_[static_cast<std::size_t>(k)] = log_alpha_(p, s - k) + log_p[static_cast<std::size_t>(k)];
    predicted_(p, s) = stays + log_sum({terms_.data(), static_cast<std::size_t>(most) + 1});
  }
  std::size_t held = 0;
  double beyond = impossible;
  for (Eigen::Index k = reach; k >= 1; --k) {
    beyond = log_sum(beyond, log_p[static_cast<std::size_t>(k)]);
    terms_[held++] = stays + log_alpha_(p, last - k) + beyond;
  }
  terms_[held++] = std::log1p(-config_.finish) + log_alpha_(p, last);
  predicted_(p, last) = log_sum({terms_.data(), held});
}

void SequenceHmm::weigh(std::span<const double> sample) {
  for (Eigen::Index p = 0; p < log_alpha_.rows(); ++p)
    for (Eigen::Index s = 0; s < log_alpha_.cols(); ++s)
      log_alpha_(p, s) += emission(primitives_[static_cast<std::size_t>(p)], s, sample);
  for (std::size_t d = 0; d < sample.size(); ++d)
    if (!std::isnan(sample[d])) log_none_ += std::log(background_density_[static_cast<Eigen::Index>(d)]);
  const double all = log_sum(log_none_, log_sum({log_alpha_.data(), static_cast<std::size_t>(log_alpha_.size())}));
  log_alpha_.array() -= all;
  log_none_ -= all;
  belief_.log_likelihood += all;
}

double SequenceHmm::emission(const SequencePrimitive& primitive, Eigen::Index step,
                             std::span<const double> sample) const {
  double log_density = 0;
  for (std::size_t d = 0; d < sample.size(); ++d) {
    if (std::isnan(sample[d])) continue;
    const auto column = static_cast<Eigen::Index>(d);
    const double variance = primitive.variance(step, column), away = sample[d] - primitive.mean(step, column);
    log_density -= 0.5 * (away * away / variance + std::log(2 * std::numbers::pi * variance));
  }
  return log_density;
}

void SequenceHmm::summarise() {
  const auto last = static_cast<double>(log_alpha_.cols() - 1);
  belief_.steps = log_alpha_.array().exp();
  belief_.probabilities = belief_.steps.rowwise().sum();
  belief_.none = std::exp(log_none_);
  belief_.recognised = -1;
  double best = belief_.none;
  for (Eigen::Index p = 0; p < log_alpha_.rows(); ++p) {
    double mean = 0;
    for (Eigen::Index s = 0; s < log_alpha_.cols(); ++s) mean += static_cast<double>(s) / last * belief_.steps(p, s);
    belief_.progress[p] =
        belief_.probabilities[p] > 0 ? mean / belief_.probabilities[p] : std::numeric_limits<double>::quiet_NaN();
    if (belief_.probabilities[p] > best || (p == 0 && belief_.probabilities[p] == best)) {
      best = belief_.probabilities[p];
      belief_.recognised = static_cast<int>(p);
    }
  }
}

}  // namespace lfdcore
