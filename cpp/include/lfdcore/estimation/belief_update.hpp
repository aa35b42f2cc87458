// One step of the filter over the driver's goal: wider by the time, surer by the action (Sec. 2.3, Eq. 2.2-2.3).
#pragma once

#include "lfdcore/estimation/action_model.hpp"

namespace lfdcore {

/// With `process_noise` [m^2] more variance along every axis, then cut where that is wider than the prior: what is
/// known of the goals is not forgotten (not cut if the prior is singular). 0 leaves the belief as it is.
Belief widened(const Belief& belief, const Belief& prior, double process_noise);

/// p(g | y) of p(g) = `belief` and the moments of (y, g) (2.2-2.3), without variances below 0 that rounding leaves.
/// Throws std::invalid_argument for an action of another size or beyond +-1e20, if its covariance is singular and if
/// what comes out is no belief.
Belief conditioned(const Belief& belief, const ActionMoments& moments, const ActionVector& action);

}  // namespace lfdcore
