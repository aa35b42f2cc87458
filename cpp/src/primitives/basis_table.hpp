// Centres and widths of the basis functions, and the exact solution of 5.1 between samples.
#pragma once

#include <cstddef>
#include <vector>

#include "lfdcore/primitives/basis.hpp"

namespace lfdcore::detail {

/// Checked and computed once, then asked for any phase.
class BasisTable {
 public:
  explicit BasisTable(const DmpConfig& config);

  /// phi(x) into width() doubles: M values, then zeros.
  void row(double phase, double* values) const;
  /// The same at normalised time s, x = exp(-alpha_x s).
  void row_at(double time, double* values) const { row(std::exp(-config_.phase_decay * time), values); }

  std::size_t functions() const { return static_cast<std::size_t>(config_.basis_functions); }
  std::size_t width() const { return centres_.size(); }
  const DmpConfig& config() const { return config_; }

 private:
  DmpConfig config_;
  std::vector<double> centres_, widths_;  // padded with functions that are 0 everywhere
};

/// exp(A s) for the state (y - g, y') of 5.1 without forcing.
struct Transition {
  double yy, yv, vy, vv;
};
Transition transition(const DmpConfig& config, double duration);

/// One step of 5.1 in normalised time: the transition is exact, the forcing's integral a Gauss-Legendre sum of order 6.
struct ForcedStep {
  static constexpr int nodes = 3;
  double duration;
  Transition free;
  double at[nodes];        ///< times of the nodes, since the step's begin
  double position[nodes];  ///< what forcing at the node adds to y
  double velocity[nodes];  ///< and to y'

  ForcedStep(const DmpConfig& config, double duration);
};

/// Steps that a span of normalised time needs, so that the sum's error stays near 1e-10 of the forcing's effect.
int steps_within(const DmpConfig& config, double span);

}  // namespace lfdcore::detail
