// What a driver does on the way to a goal: Gaussian processes p(y_a | goal, state), and their moments for an uncertain
// goal (Sec. 2.3, ERRATA 1-4 and 14).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "lfdcore/estimation/belief.hpp"
#include "lfdcore/row_matrix.hpp"

namespace lfdcore {

constexpr int most_actions = 4;
using ActionVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most_actions, 1>;
using ActionMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most_actions, most_actions>;
using CrossMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most_goal_dimensions, most_actions>;

/// k((x, g), (x', g')) = a^2 exp(-r^2 / 2), r over state and goal (C.5): one output's. H is diag(l_d^2) (ERRATA 3, 8).
struct ActionKernel {
  double amplitude = 1;                ///< a, the standard deviation of f, in the action's unit
  Eigen::VectorXd state_lengthscales;  ///< (Dx,), in the state's units
  Eigen::VectorXd goal_lengthscales;   ///< (Dg,) [m]
  double noise = 0;                    ///< s, a standard deviation: y = f + e, e ~ N(0, s^2)
};

/// Throws std::invalid_argument unless amplitude and length-scales are > 0 and in [1e-20, 1e20], noise in [0, 1e20] and
/// 1 <= Dg <= 4.
void validate(const ActionKernel& kernel);

/// Joint moments of the action y and the goal g ~ N(mu, Sigma).
struct ActionMoments {
  ActionVector mean;             ///< m (Da,)
  ActionMatrix covariance;       ///< G (Da, Da): of y, so with the noise (ERRATA 2)
  CrossMatrix cross_covariance;  ///< C (Dg, Da): of g with y
};

/// Conditioned once, then asked as often as wanted. Immutable, so copies share their data and any thread may ask.
class ActionModel {
 public:
  /// States (N, Dx), goals (N, Dg) [m], actions (N, Da), a kernel for every action. Without `subset` all samples are
  /// used. With it, the samples named by it: if `projected`, as the basis of a predictor that keeps all N targets (DTC,
  /// ERRATA 14; a sample within 1e-5 a of what the others of the subset span adds nothing and is left out); else as a
  /// smaller training set, as the thesis has it. Throws std::invalid_argument for no or ill-fitting data, numbers
  /// beyond
  /// +-1e20, indices out of range or named twice, and a covariance that is not positive definite.
  ActionModel(const RowMatrix& states, const RowMatrix& goals, const RowMatrix& actions,
              std::vector<ActionKernel> kernels, const std::vector<std::int64_t>* subset = nullptr,
              bool projected = true);

  /// Exact moments at state (Dx,) for a goal that is distributed as `belief`. No allocation; scratch holds
  /// scratch_size() doubles. Throws std::invalid_argument for other sizes, for a state beyond +-1e20 and as
  /// validate(belief) does.
  ActionMoments moments(std::span<const double> state, const Belief& belief, std::span<double> scratch) const;
  std::size_t scratch_size() const;

  Eigen::Index size() const;  ///< samples asked for: N, or the subset's
  int state_dimensions() const;
  int goal_dimensions() const;
  int actions() const;
  /// Goals that differ, if they are few enough for the sums over pairs of samples to become sums over pairs of goals;
  /// 0 if each sample has to be taken with its own goal.
  int shared_goals() const;
  std::size_t nbytes() const;  ///< memory held
  const std::vector<ActionKernel>& kernels() const;

 private:
  struct Conditioned;
  std::shared_ptr<const Conditioned> data_;
};

}  // namespace lfdcore
