// Interaction primitives (5.6-5.15) and their extension by the environment (5.16-5.19): a Gaussian over the parameters
// of S demonstrations, conditioned on what is seen of the partner and of the scene.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "lfdcore/primitives/dmp.hpp"

namespace lfdcore {

struct InteractionPrimitiveConfig {
  DmpConfig dmp{};
  /// What of the partner enters the likelihood, and by what the demonstrations are fitted: the positions themselves,
  /// or the forcing function as printed (5.11), which differentiates twice.
  Observed observe = Observed::positions;
  /// sigma^2, a variance in the unit of what is observed (ERRATA 41). Default: the partner's squared residual after the
  /// fit, pooled over samples, dimensions and demonstrations (ERRATA F13).
  std::optional<double> noise{};
  double environment_noise = 1e-3;  ///< sigma_e^2, a variance of the standardised environment (ERRATA 43, F13)
  /// The environment as w_e theta, w_e = e theta^+ as printed after 5.16, instead of jointly Gaussian with theta
  /// (ERRATA 42). The same for S <= D.
  bool printed_environment_weights = false;
};

/// Throws std::invalid_argument unless the variances are > 0 and finite, and as validate(config.dmp) does.
void validate(const InteractionPrimitiveConfig& config);

/// N degrees of freedom, the partner's first, at `steps` samples evenly spread over the motion.
struct InteractionTrajectory {
  Eigen::MatrixXd mean;  ///< (steps, N)
  RowMatrix covariance;  ///< (steps, N * N), row-major (N, N) each
};

namespace detail {
struct InteractionModel;
struct Information;
}  // namespace detail

/// p(theta | seen): N(mean, factor factor^T), of rank < S. Immutable; copies share their data; any thread may ask.
class InteractionPosterior {
 public:
  InteractionPosterior(std::shared_ptr<const detail::InteractionModel> model, const detail::Information& seen);

  Eigen::VectorXd mean() const;    ///< (D,), D = N (M + 1): w_1, g_1, w_2, ...
  Eigen::MatrixXd factor() const;  ///< (D, S): the covariance is factor factor^T
  Eigen::VectorXd start() const;   ///< (N,) expected begin of the motion
  double trace() const;            ///< of theta's covariance
  /// ln p(what was seen), the environment standardised: 5.14's first block, by the matrix determinant lemma.
  double log_likelihood() const { return log_likelihood_; }

  /// Mean and covariance of the motion, which is linear in theta and the start.
  InteractionTrajectory trajectory(int steps) const;
  RowMatrix sample(int count, std::uint64_t seed) const;  ///< (count, D)
  /// `count` motions (steps, N), of the same draws as sample().
  std::vector<RowMatrix> sample_trajectories(int count, int steps, std::uint64_t seed) const;

  Dmp robot() const;    ///< of the mean, the robot's degrees of freedom
  Dmp partner() const;  ///< of the mean, the partner's

 private:
  Dmp motion(Eigen::Index first, Eigen::Index count) const;

  std::shared_ptr<const detail::InteractionModel> model_;
  Eigen::VectorXd latent_;  // (S,) mean of z, theta = mu + L z (ERRATA 40)
  Eigen::MatrixXd spread_;  // (S, S) upper triangular, cov z = spread spread^T
  double log_likelihood_ = 0;
};

/// Gathers what is seen, sample by sample: an S x S matrix of information. One thread at a time.
class InteractionObserver {
 public:
  InteractionObserver(std::shared_ptr<const detail::InteractionModel> model,
                      const std::optional<Eigen::VectorXd>& environment);
  InteractionObserver(InteractionObserver&&) noexcept;
  ~InteractionObserver();

  /// The partner at `phase`: forcing (n,), or positions (n,), as the config says; NaN where it was not seen. Any order;
  /// with positions, later phases first cost more.
  void observe(double phase, const Eigen::VectorXd& values);
  InteractionPosterior posterior() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

class InteractionPrimitive {
 public:
  /// From stored samples: parameters (S >= 2, N (M + 1)), starts (S, N), environment (S, E) or none, of the N degrees
  /// of freedom the first `partner` are the partner's. config.noise must be set. Throws std::invalid_argument for
  /// shapes that do not fit, what is not finite, and an environment column that does not vary.
  InteractionPrimitive(const RowMatrix& parameters, const RowMatrix& starts,
                       const std::optional<RowMatrix>& environment, int partner,
                       const InteractionPrimitiveConfig& config);

  /// S >= 2 demonstrations: partner (T_j, n) and robot (T_j, r), each fitted in its own normalised time, so that their
  /// lengths may differ. Throws std::invalid_argument as Dmp::fit does, and for different dimensions or counts.
  static InteractionPrimitive fit(const std::vector<RowMatrix>& partner, const std::vector<RowMatrix>& robot,
                                  const std::optional<RowMatrix>& environment,
                                  const InteractionPrimitiveConfig& config = {});

  /// p(theta | partner's positions (K, n) at falling phases (K,), environment (E,)). NaN: not seen; K = 0 and no
  /// environment give the prior. Forcing needs 3 seen samples in a row; what stands alone is left out. Phases are in
  /// [exp(-alpha_x), 1]: an observation longer than the motion is refused.
  InteractionPosterior condition(const RowMatrix& partner, const Eigen::VectorXd& phase,
                                 const std::optional<Eigen::VectorXd>& environment) const;

  InteractionObserver begin(const std::optional<Eigen::VectorXd>& environment) const;

  const RowMatrix& parameters() const;
  const RowMatrix& starts() const;
  const std::optional<RowMatrix>& environment() const;
  int partner_dimensions() const;
  int robot_dimensions() const;
  const InteractionPrimitiveConfig& config() const;  ///< with the noise in use

 private:
  std::shared_ptr<const detail::InteractionModel> model_;
};

/// F of 5.12 of a partner's positions (K, n) at falling phases (K,); NaN where fewer than 3 samples in a row were seen.
RowMatrix partner_forcing(const RowMatrix& positions, const Eigen::VectorXd& phase, const DmpConfig& config = {});

}  // namespace lfdcore
