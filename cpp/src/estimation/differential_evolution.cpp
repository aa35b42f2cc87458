#include "lfdcore/estimation/differential_evolution.hpp"

#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

void check_bounds(const RowMatrix& bounds) {
  require(bounds.rows() > 0 && bounds.cols() == 2,
          "bounds must be (D, 2), got (" + std::to_string(bounds.rows()) + ", " + std::to_string(bounds.cols()) + ")");
  for (Eigen::Index d = 0; d < bounds.rows(); ++d)
    require(bounds.row(d).allFinite() && bounds(d, 0) < bounds(d, 1) && std::isfinite(bounds(d, 1) - bounds(d, 0)),
            "bounds of parameter " + std::to_string(d) + " are " + std::to_string(bounds(d, 0)) + " and " +
                std::to_string(bounds(d, 1)) + ", must be finite and rising");
}

// The standard's distributions differ between libraries; these do not.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  Eigen::Index below(Eigen::Index count) { return static_cast<Eigen::Index>(unit() * static_cast<double>(count)); }

 private:
  std::mt19937_64 engine_;
};

class Evolution {
 public:
  Evolution(const BoundedObjective& objective, const RowMatrix& bounds, const DifferentialEvolutionConfig& config)
      : objective_(objective),
        low_(bounds.col(0)),
        range_(bounds.col(1) - bounds.col(0)),
        config_(config),
        random_(config.seed) {}

  DifferentialEvolutionResult run() {
    start();
    DifferentialEvolutionResult result;
    while (result.generations < config_.generations && !result.converged) {
      generation();
      ++result.generations;
      result.converged = settled();
    }
    result.best = low_ + range_.cwiseProduct(members_.col(best_));
    result.value = values_(best_);
    result.evaluations = evaluations_;
    return result;
  }

 private:
  // A Latin hypercube: every parameter's range is covered evenly. Members live in the unit cube.
  void start() {
    const Eigen::Index D = low_.size(), count = std::max<Eigen::Index>(5, config_.population * D);
    members_.resize(D, count);
    std::vector<Eigen::Index> strata(static_cast<std::size_t>(count));
    for (Eigen::Index d = 0; d < D; ++d) {
      std::iota(strata.begin(), strata.end(), Eigen::Index{0});
      for (Eigen::Index m = 0; m < count; ++m) {
        std::swap(strata[std::size_t(m)], strata[std::size_t(m + random_.below(count - m))]);
        members_(d, m) = (static_cast<double>(strata[std::size_t(m)]) + random_.unit()) / static_cast<double>(count);
      }
    }
    values_.resize(count);
    for (Eigen::Index m = 0; m < count; ++m) values_(m) = evaluate(members_.col(m), infinity);
    values_.minCoeff(&best_);
  }

  void generation() {
    const double weight =
        config_.mutation_low + (config_.mutation_high - config_.mutation_low) * random_.unit();  // dither
    for (Eigen::Index m = 0; m < members_.cols(); ++m) {
      mutate(m, weight);
      const double value = evaluate(trial_, values_(m));
      if (value > values_(m)) continue;
      members_.col(m) = trial_;
      values_(m) = value;
      if (value < values_(best_)) best_ = m;
    }
  }

  // best + weight (a - b), crossed with the member; a parameter that leaves the box is drawn anew.
  void mutate(Eigen::Index m, double weight) {
    const Eigen::Index count = members_.cols();
    Eigen::Index a = m, b = m;
    while (a == m) a = random_.below(count);
    while (b == m || b == a) b = random_.below(count);
    trial_ = members_.col(m);
    const Eigen::Index always = random_.below(trial_.size());
    for (Eigen::Index d = 0; d < trial_.size(); ++d) {
      if (random_.unit() >= config_.recombination && d != always) continue;
      trial_(d) = members_(d, best_) + weight * (members_(d, a) - members_(d, b));
      if (trial_(d) < 0 || trial_(d) > 1) trial_(d) = random_.unit();
    }
  }

  double evaluate(const Eigen::VectorXd& member, double worth) {
    point_ = low_ + range_.cwiseProduct(member);
    ++evaluations_;
    const double value = objective_({point_.data(), static_cast<std::size_t>(point_.size())}, worth);
    return std::isnan(value) ? infinity : value;
  }

  bool settled() const {
    if (!values_.allFinite()) return false;
    const double mean = values_.mean(), spread = std::sqrt((values_.array() - mean).square().mean());
    return spread <= config_.absolute_tolerance + config_.tolerance * std::abs(mean);
  }

  const BoundedObjective& objective_;
  Eigen::VectorXd low_, range_;
  DifferentialEvolutionConfig config_;
  Random random_;
  Eigen::MatrixXd members_;  // (D, population)
  Eigen::VectorXd values_, trial_, point_;
  Eigen::Index best_ = 0;
  long evaluations_ = 0;
};

}  // namespace

void validate(const DifferentialEvolutionConfig& config) {
  require_between("population", config.population, 1, 1e6, "members a parameter");
  require_between("generations", config.generations, 0, 1e9, "");
  require_between("recombination", config.recombination, 0, 1, "");
  require_between("mutation_low", config.mutation_low, 0, 2, "");
  require_between("mutation_high", config.mutation_high, config.mutation_low, 2, "");
  require_between("tolerance", config.tolerance, 0, 1e300, "");
  require_between("absolute_tolerance", config.absolute_tolerance, 0, 1e300, "");
}

DifferentialEvolutionResult differential_evolution(const BoundedObjective& objective, const RowMatrix& bounds,
                                                   const DifferentialEvolutionConfig& config) {
  validate(config);
  check_bounds(bounds);
  return Evolution(objective, bounds, config).run();
}

DifferentialEvolutionResult maximise_likelihood(GaussianProcessLikelihood& likelihood, const RowMatrix& bounds,
                                                const DifferentialEvolutionConfig& config) {
  require(bounds.rows() == likelihood.parameters(),
          "bounds must have a row for log a, every log length-scale and log noise: " +
              std::to_string(likelihood.parameters()) + ", got " + std::to_string(bounds.rows()));
  auto result = differential_evolution(
      [&](std::span<const double> x, double worth) { return -likelihood.evaluate(x, -worth); }, bounds, config);
  result.value = -result.value;
  return result;
}

}  // namespace lfdcore
