// Which task a partner has begun, as a hidden Markov model over primitives (Sec. 6.2.2).
#pragma once

#include <span>
#include <vector>

#include "lfdcore/row_matrix.hpp"

namespace lfdcore {

/// Probabilities are a sample's. All fields are stated, none is learned.
struct SequenceConfig {
  int phase_steps = 50;           ///< S, states a primitive, 2..1000
  double pause = 0.1;             ///< P(the partner stands still), [0, 1)
  double finish = 0.1;            ///< P(a primitive's last step is left), (0, 1]
  double chain = 0.5;             ///< P(another primitive begins at once | one was left), else "none of them", [0, 1]
  double abandon = 0.001;         ///< P(any other step -> "none of them"), [0, 1)
  double start = 0.02;            ///< P("none of them" -> the beginning of a primitive), [0, 1]
  double none_prior = 0.1;        ///< P("none of them" at the first sample), [0, 1)
  double background_width = 1.5;  ///< "none of them" is uniform over this many times the demonstrations' range, > 0
  double widening = 1.5;          ///< factor on the demonstrations' variance, > 0: a few of them show too little of it
  double least_deviation = 0.02;  ///< least standard deviation, as a share of the demonstrations' range, > 0
};

/// Throws std::invalid_argument, naming the field and its bounds.
void validate(const SequenceConfig& config);

/// A partner's movement over the phase grid s / (S - 1).
struct SequencePrimitive {
  RowMatrix mean;      ///< (S, D)
  RowMatrix variance;  ///< (S, D) > 0
  double samples = 0;  ///< mean duration in samples, >= 2: tempo 1
};

/// What is known after a sample.
struct SequenceBelief {
  Eigen::VectorXd probabilities;  ///< (P,) that the partner is within each primitive
  double none = 0;                ///< that it is in none of them; all sum to 1
  RowMatrix steps;                ///< (P, S) joint probabilities of primitive and phase step
  Eigen::VectorXd progress;       ///< (P,) mean of s / (S - 1) given the primitive, NaN where its probability is 0
  int recognised = -1;            ///< the most probable, ties to the first primitive; -1 = none of them
  double log_likelihood = 0;      ///< ln p(all samples so far)
};

/// Left to right through the steps of each primitive: a sample advances by 0 with probability `pause`, else by a
/// Poisson-distributed number of steps; the mean is S - 1 steps in `samples` samples, slower and faster partners are
/// the distribution's tails. The last step holds until it is left. Samples are independent Gaussians around a step's
/// mean, diagonal; in "none of them" they have a constant density. Positions
/// and their differences from the sample before, side by side, tell tasks apart sooner than positions. Forward filter
/// in log space; one caller at a time.
class SequenceHmm {
 public:
  /// `background_density` [1 / unit] (D,): that of "none of them" in each dimension. Throws std::invalid_argument for
  /// no primitives, for those that do not fit each other or the config, and for what is not finite and positive.
  SequenceHmm(std::vector<SequencePrimitive> primitives, Eigen::VectorXd background_density,
              const SequenceConfig& config = {});

  /// From demonstrations[p], each (T, D) with T >= 2, sampled as the partner will be: each is stretched to the grid;
  /// the variance is theirs (unbiased, averaged with its mean over the phase) times `widening`, plus that of a step's
  /// extent, and at least `least_deviation` squared. Throws std::invalid_argument for none of them, for other shapes
  /// and for what is not finite and within 1e100, naming primitive and demonstration.
  static SequenceHmm fit(const std::vector<std::vector<RowMatrix>>& demonstrations, const SequenceConfig& config = {});

  /// One step of the forward filter with the partner's sample (D,). NaN in a dimension: not seen, the others count; a
  /// sample without any only lets time pass. No allocation. Throws std::invalid_argument, and stays as it was, for
  /// another D and for what is infinite or beyond 1e100.
  const SequenceBelief& observe(std::span<const double> sample);
  void reset();  ///< to the prior, before the first sample

  const SequenceBelief& belief() const { return belief_; }
  const std::vector<SequencePrimitive>& primitives() const { return primitives_; }
  const SequenceConfig& config() const { return config_; }
  const Eigen::VectorXd& background_density() const { return background_density_; }
  int dimensions() const { return static_cast<int>(background_density_.size()); }  ///< D

  /// ln P(a sample advances by k steps), k = 0, 1, .. (K,): what the phase steps of primitive p move by.
  const std::vector<double>& log_advances(int p) const { return log_advances_[static_cast<std::size_t>(p)]; }

 private:
  void predict();
  void advance(Eigen::Index p);
  void weigh(std::span<const double> sample);
  double emission(const SequencePrimitive& primitive, Eigen::Index step, std::span<const double> sample) const;
  void summarise();

  std::vector<SequencePrimitive> primitives_;
  Eigen::VectorXd background_density_;
  SequenceConfig config_;
  std::vector<std::vector<double>> log_advances_;
  RowMatrix log_alpha_, predicted_;  // (P, S)
  double log_none_ = 0;
  bool begun_ = false;
  std::vector<double> terms_;
  SequenceBelief belief_;
};

}  // namespace lfdcore
