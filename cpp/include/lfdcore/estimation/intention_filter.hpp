// The belief over the driver's goal, updated action by action (Sec. 2.3, Eq. 2.2-2.3).
#pragma once

#include <span>
#include <vector>

#include "lfdcore/estimation/action_model.hpp"

namespace lfdcore {

/// One caller at a time.
class IntentionFilter {
 public:
  /// `process_noise` [m^2] widens the belief before every update, but not beyond the prior (belief_update.hpp). 0 is
  /// the thesis: then successive actions count as independent and the belief gets overconfident (ERRATA 6). Throws
  /// std::invalid_argument for a prior that is none of the model's goals and for a process noise outside
  /// [0, 1e40] m^2.
  IntentionFilter(ActionModel model, Belief prior, double process_noise = 0);

  /// 2.2-2.3 with the action (Da,) taken at state (Dx,). No allocation. Throws std::invalid_argument, and leaves the
  /// belief as it was, for other sizes, for an action beyond +-1e20, a belief that would be none and if the action's
  /// covariance is singular (no noise).
  const Belief& update(std::span<const double> state, std::span<const double> action);
  void reset();  ///< to the prior

  const Belief& belief() const { return belief_; }
  const ActionModel& model() const { return model_; }
  double process_noise() const { return process_noise_; }

 private:
  ActionModel model_;
  Belief prior_, belief_;
  double process_noise_;
  std::vector<double> scratch_;
};

}  // namespace lfdcore
