// Dynamic movement primitives of many degrees of freedom (5.1-5.4; tau is a rate, ERRATA 34).
#pragma once

#include <memory>
#include <optional>

#include "lfdcore/primitives/basis.hpp"

namespace lfdcore {

/// The space in which motions are compared: that of the forcing function (5.3, 5.11), or that of the positions.
enum class Observed { forcing, positions };

/// A motion of D degrees of freedom. The matrices are column by column, so that one degree of freedom is contiguous.
struct DmpTrajectory {
  Eigen::VectorXd time;           ///< (steps,) [s] since the begin
  Eigen::MatrixXd positions;      ///< (steps, D)
  Eigen::MatrixXd velocities;     ///< (steps, D) a second
  Eigen::MatrixXd accelerations;  ///< (steps, D) a second squared
};

/// Where and how fast a motion runs. Without position: the primitive's own start; without velocity: at rest; without
/// duration: until a demonstration's end, (1 - s) / rate, s the normalised time of the phase.
struct DmpRun {
  double rate = 1;   ///< tau [1/s] = 1 / duration of the whole motion
  double phase = 1;  ///< x at the begin, in (0, 1]
  std::optional<Eigen::VectorXd> position{}, velocity{};
  std::optional<double> duration{};  ///< [s]
};

class DmpStepper;

/// y'' = (alpha_y (beta_y (g - y) - y' / tau) + phi(x)^T w) tau^2 for every degree of freedom.
class Dmp {
 public:
  /// Start (D,), goal (D,), weights (D, M). Throws std::invalid_argument for other shapes and what is not finite.
  Dmp(Eigen::VectorXd start, Eigen::VectorXd goal, RowMatrix weights, const DmpConfig& config = {});

  /// Positions (T, D), T >= 3, evenly spaced in time: t = k / (T - 1), whatever the demonstration's duration was. By
  /// forcing: the derivatives are second-order differences, the weights least squares of 5.3, the goal is the last
  /// position (5.4, ERRATA 37). By positions: start, goal and weights are least squares of the motion from rest itself,
  /// without derivatives, which noise spoils. Orthogonal decompositions, minimum norm where data say nothing. Throws
  /// std::invalid_argument for fewer samples and for what is not finite or beyond 1e9.
  static Dmp fit(const RowMatrix& positions, const DmpConfig& config = {}, Observed by = Observed::forcing);

  /// The motion in `steps` >= 2 samples, evenly spread. Exact up to 1e-9 of its range. Linear in (w, g, position,
  /// velocity): the matrix that maps them to the samples is kept for the next call with the same steps, phase and
  /// duration * rate. Any thread may call.
  DmpTrajectory rollout(int steps, const DmpRun& run = {}) const;

  /// Begins a motion that is stepped; `run.duration` is not used.
  DmpStepper begin(const DmpRun& run = {}) const;

  Eigen::Index dimensions() const { return start_.size(); }
  const Eigen::VectorXd& start() const { return start_; }
  const Eigen::VectorXd& goal() const { return goal_; }
  const RowMatrix& weights() const { return weights_; }
  const DmpConfig& config() const { return config_; }

 private:
  DmpConfig config_;
  Eigen::VectorXd start_, goal_;
  RowMatrix weights_;
};

/// Forcing terms (T, D) of positions (T, D) at normalised times k / (T - 1): 5.3 for the goal g (D,).
RowMatrix forcing_terms(const RowMatrix& positions, const Eigen::VectorXd& goal, const DmpConfig& config = {});

/// A motion that is run step by step; goal and rate may be set between steps. One thread at a time.
class DmpStepper {
 public:
  DmpStepper(const Dmp& dmp, const DmpRun& run);
  DmpStepper(DmpStepper&&) noexcept;
  ~DmpStepper();

  /// Advances by dt >= 0 [s], exact up to 1e-9 of the range whatever dt is. Allocates nothing.
  void step(double dt);

  void set_goal(const Eigen::VectorXd& goal);  ///< (D,); position and velocity stay continuous
  void set_rate(double rate);                  ///< [1/s] > 0; position and velocity stay continuous

  const Eigen::VectorXd& position() const;
  const Eigen::VectorXd& velocity() const;  ///< a second
  const Eigen::VectorXd& goal() const;
  double rate() const;
  double phase() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lfdcore
