#include "differences.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "lfdcore/error.hpp"

namespace lfdcore::detail {

namespace {

// The slope at t0 of the parabola through three samples.
double slope(double t0, double ta, double ya, double tb, double yb, double tc, double yc) {
  return ya * (2 * t0 - tb - tc) / ((ta - tb) * (ta - tc)) + yb * (2 * t0 - ta - tc) / ((tb - ta) * (tb - tc)) +
         yc * (2 * t0 - ta - tb) / ((tc - ta) * (tc - tb));
}

}  // namespace

Eigen::VectorXd derivative(const Eigen::Ref<const Eigen::VectorXd>& y, const Eigen::Ref<const Eigen::VectorXd>& t) {
  const Eigen::Index last = y.size() - 1;
  Eigen::VectorXd slopes(y.size());
  for (Eigen::Index k = 0; k <= last; ++k) {
    const Eigen::Index m = std::clamp<Eigen::Index>(k, 1, last - 1);
    slopes[k] = slope(t[k], t[m - 1], y[m - 1], t[m], y[m], t[m + 1], y[m + 1]);
  }
  return slopes;
}

Eigen::VectorXd observed_forcing(const Eigen::Ref<const Eigen::VectorXd>& positions,
                                 const Eigen::Ref<const Eigen::VectorXd>& time, const DmpConfig& config) {
  const Eigen::VectorXd velocity = derivative(positions, time);
  return derivative(velocity, time) + config.stiffness * (config.damping * positions + velocity);
}

void require_positions(const Series& positions, const char* name) {
  constexpr double most = 1e9;
  for (Eigen::Index k = 0; k < positions.rows(); ++k)
    for (Eigen::Index d = 0; d < positions.cols(); ++d)
      if (!(std::abs(positions(k, d)) <= most))
        require_between(std::string(name) + "[" + std::to_string(k) + ", " + std::to_string(d) + "]", positions(k, d),
                        -most, most, "");
}

}  // namespace lfdcore::detail
