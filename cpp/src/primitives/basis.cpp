#include "lfdcore/primitives/basis.hpp"

#include <algorithm>
#include <limits>
#include <tuple>

#include "basis_kernel.hpp"
#include "basis_table.hpp"
#include "lfdcore/error.hpp"
#include "small_products.hpp"

namespace lfdcore {

void validate(const DmpConfig& config) {
  require_between("basis_functions", config.basis_functions, 2, 1000, "");
  for (const auto& [name, value, most] : {std::tuple{"stiffness", config.stiffness, 1e4},
                                          {"damping", config.damping, 1e4},
                                          {"phase_decay", config.phase_decay, 100.0}}) {
    require_positive(name, value, "");
    require_between(name, value, 0, most, "");
  }
}

Eigen::VectorXd phases(int steps, const DmpConfig& config) {
  validate(config);
  require_between("steps", steps, 2, 1e6, "samples");
  return (Eigen::VectorXd::LinSpaced(steps, 0, 1) * -config.phase_decay).array().exp();
}

RowMatrix basis(const Eigen::VectorXd& phase, const DmpConfig& config) {
  const detail::BasisTable table(config);
  RowMatrix values(phase.size(), config.basis_functions);
  Eigen::VectorXd row(static_cast<Eigen::Index>(table.width()));
  for (Eigen::Index k = 0; k < phase.size(); ++k) {
    require_between("phase", phase[k], std::numeric_limits<double>::min(), 1, "");
    table.row(phase[k], row.data());
    values.row(k) = row.head(config.basis_functions);
  }
  return values;
}

namespace detail {

BasisTable::BasisTable(const DmpConfig& config) : config_(config) {
  validate(config);
  const std::size_t count = functions();
  constexpr double nowhere = 1e6;
  centres_.assign(padded(count), nowhere);
  widths_.assign(padded(count), nowhere);
  for (std::size_t i = 0; i < count; ++i) centres_[i] = std::exp(-config.phase_decay * double(i) / double(count - 1));
  for (std::size_t i = 0; i + 1 < count; ++i)
    widths_[i] = 1 / ((centres_[i] - centres_[i + 1]) * (centres_[i] - centres_[i + 1]));
  widths_[count - 1] = widths_[count - 2];
}

void BasisTable::row(double phase, double* values) const {
  basis_row(phase, centres_.data(), widths_.data(), width(), values);
  std::fill(values + functions(), values + width(), 0.0);
}

Transition transition(const DmpConfig& config, double duration) {
  const double product = config.stiffness * config.damping, half = config.stiffness / 2;
  const double square = half * half - product;
  double even = std::exp(-half * duration), odd = even * duration;  // critically damped
  if (square > 1e-12 * half * half) {
    const double root = std::sqrt(square), slow = std::exp((root - half) * duration);
    odd = slow * -std::expm1(-2 * root * duration) / (2 * root);
    even = slow - root * odd;
  } else if (square < -1e-12 * half * half) {
    const double root = std::sqrt(-square);
    odd = even * std::sin(root * duration) / root;
    even *= std::cos(root * duration);
  }
  return {even + half * odd, odd, -product * odd, even - half * odd};
}

ForcedStep::ForcedStep(const DmpConfig& config, double step) : duration(step), free(transition(config, step)) {
  constexpr double offset = 0.3872983346207417;  // sqrt(.6) / 2
  constexpr double where[nodes] = {0.5 - offset, 0.5, 0.5 + offset}, weights[nodes] = {5 / 18., 8 / 18., 5 / 18.};
  for (int i = 0; i < nodes; ++i) {
    const Transition rest = transition(config, step * (1 - where[i]));
    at[i] = step * where[i];
    position[i] = step * weights[i] * rest.yv;
    velocity[i] = step * weights[i] * rest.vv;
  }
}

int steps_within(const DmpConfig& config, double span) {
  const double fastest = std::max(config.stiffness, std::sqrt(config.stiffness * config.damping));
  const double longest = std::min(1 / fastest, 0.125 / (config.basis_functions - 1));
  return std::max(1, static_cast<int>(std::ceil(span / longest * (1 - 1e-12))));
}

}  // namespace detail
}  // namespace lfdcore
