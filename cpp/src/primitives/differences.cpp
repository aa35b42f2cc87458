#include "differences.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "lfdcore/error.hpp"

namespace lfdcore::detail {

namespace {

/// Weights of three neighbours in the slope at each sample, second order inside and at the ends.
struct Slopes {
  Eigen::Matrix<double, Eigen::Dynamic, 3> weights;

  explicit Slopes(const Eigen::VectorXd& t) : weights(t.size(), 3) {
    for (Eigen::Index k = 0; k < t.size(); ++k) {
      const Eigen::Index m = middle(k);
      const double left = t[m] - t[m - 1], right = t[m + 1] - t[m], at = t[k] - t[m], both = left + right;
      weights(k, 0) = (2 * at - right) / (left * both);
      weights(k, 2) = (2 * at + left) / (right * both);
      weights(k, 1) = -weights(k, 0) - weights(k, 2);
    }
  }

  Eigen::Index middle(Eigen::Index k) const { return std::clamp<Eigen::Index>(k, 1, weights.rows() - 2); }

  void apply(const double* y, double* out) const {
    for (Eigen::Index k = 0; k < weights.rows(); ++k) {
      const Eigen::Index m = middle(k);
      out[k] = weights(k, 0) * y[m - 1] + weights(k, 1) * y[m] + weights(k, 2) * y[m + 1];
    }
  }
};

}  // namespace

Eigen::MatrixXd observed_forcing(const Eigen::MatrixXd& positions, const Eigen::VectorXd& time,
                                 const DmpConfig& config) {
  const Slopes slopes(time);
  Eigen::MatrixXd velocity(positions.rows(), positions.cols()), forcing(positions.rows(), positions.cols());
  for (Eigen::Index d = 0; d < positions.cols(); ++d) {
    slopes.apply(positions.col(d).data(), velocity.col(d).data());
    slopes.apply(velocity.col(d).data(), forcing.col(d).data());
  }
  forcing += config.stiffness * (config.damping * positions + velocity);
  return forcing;
}

void require_positions(const RowMatrix& positions, const char* name) {
  constexpr double most = 1e9;
  for (Eigen::Index k = 0; k < positions.rows(); ++k)
    for (Eigen::Index d = 0; d < positions.cols(); ++d)
      if (!(std::abs(positions(k, d)) <= most))
        require_between(std::string(name) + "[" + std::to_string(k) + ", " + std::to_string(d) + "]", positions(k, d),
                        -most, most, "");
}

}  // namespace lfdcore::detail
