// Differential evolution (Storn and Price 1997) in a box: the optimiser of Sec. 4.4.2's hyper-parameters.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "lfdcore/estimation/gaussian_process_likelihood.hpp"
#include "lfdcore/row_matrix.hpp"

namespace lfdcore {

/// best/1/bin with dither and immediate replacement, started from a Latin hypercube: SciPy's defaults.
struct DifferentialEvolutionConfig {
  int population = 15;            ///< members for every parameter
  int generations = 1000;         ///< at most
  double recombination = 0.7;     ///< probability that a parameter comes from the mutant
  double mutation_low = 0.5;      ///< the difference's weight is drawn anew for every generation from
  double mutation_high = 1.0;     ///< [mutation_low, mutation_high)
  double tolerance = 0.01;        ///< done once the values' standard deviation <= absolute_tolerance + this |mean|
  double absolute_tolerance = 0;  ///< in the objective's unit
  std::uint64_t seed = 0;
};

/// Throws std::invalid_argument for anything out of range.
void validate(const DifferentialEvolutionConfig& config);

struct DifferentialEvolutionResult {
  Eigen::VectorXd best;  ///< (D,)
  double value = 0;      ///< there
  int generations = 0;
  long evaluations = 0;
  bool converged = false;  ///< false: the generations ran out
};

/// f(x, worth): f(x), or anything above `worth` as soon as f(x) is known to be above it. NaN counts as +infinity.
using BoundedObjective = std::function<double(std::span<const double> x, double worth)>;

/// Minimises in the box of bounds (D, 2), each row (low, high). The same seed gives the same result.
/// Throws std::invalid_argument for bounds that are not finite or not low < high.
DifferentialEvolutionResult differential_evolution(const BoundedObjective& objective, const RowMatrix& bounds,
                                                   const DifferentialEvolutionConfig& config);

/// Maximises log p(Y | X) over bounds (D + 2, 2) of the log parameters; `value` is the log likelihood. Trials that
/// cannot beat their rival are given up early, which changes no step of the search.
DifferentialEvolutionResult maximise_likelihood(GaussianProcessLikelihood& likelihood, const RowMatrix& bounds,
                                                const DifferentialEvolutionConfig& config);

}  // namespace lfdcore
