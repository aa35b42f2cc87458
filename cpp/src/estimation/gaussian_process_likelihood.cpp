#include "lfdcore/estimation/gaussian_process_likelihood.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "gaussian_factor.hpp"
#include "lfdcore/error.hpp"

namespace lfdcore {

struct GaussianProcessLikelihood::Workspace {
  detail::GaussianFactor factor;
  std::vector<double> lengthscales;

  // exp of the parameters; false if one of them over- or underflows, where no likelihood is.
  bool read(std::span<const double> log_parameters, KernelFamily family, detail::GaussianScales& scales) {
    const std::size_t D = lengthscales.size();
    for (std::size_t d = 0; d < D; ++d) lengthscales[d] = std::exp(log_parameters[d + 1]);
    scales = {family, std::exp(log_parameters[0]), lengthscales, std::exp(log_parameters[D + 1])};
    const auto usable = [](double x) { return x > 1e-150 && x < 1e150; };  // so are their squares
    return usable(scales.amplitude) && std::ranges::all_of(lengthscales, usable) && scales.noise < 1e150;
  }
};

GaussianProcessLikelihood::GaussianProcessLikelihood(const RowMatrix& inputs, const Eigen::VectorXd& targets,
                                                     const Eigen::VectorXd& noise_variances, KernelFamily family)
    : workspace_(new Workspace{{inputs, targets, noise_variances},
                               std::vector<double>(static_cast<std::size_t>(inputs.cols()))}),
      family_(family) {}

GaussianProcessLikelihood::~GaussianProcessLikelihood() = default;
GaussianProcessLikelihood::GaussianProcessLikelihood(GaussianProcessLikelihood&&) noexcept = default;
GaussianProcessLikelihood& GaussianProcessLikelihood::operator=(GaussianProcessLikelihood&&) noexcept = default;

double GaussianProcessLikelihood::evaluate(std::span<const double> log_parameters, double give_up_below) {
  require(log_parameters.size() == static_cast<std::size_t>(parameters()),
          "the log parameters must be log a, log l_1 .. log l_D, log noise: one for every dimension and two");
  for (const double value : log_parameters) require(!std::isnan(value), "a log parameter is NaN");
  detail::GaussianScales scales;
  if (!workspace_->read(log_parameters, family_, scales)) return -std::numeric_limits<double>::infinity();
  return workspace_->factor.factor(scales, give_up_below);
}

double GaussianProcessLikelihood::evaluate_with_gradient(std::span<const double> log_parameters,
                                                         std::span<double> derivatives) {
  require(derivatives.size() == log_parameters.size(), "one derivative for every log parameter");
  const double value = evaluate(log_parameters);
  std::ranges::fill(derivatives, std::numeric_limits<double>::quiet_NaN());
  if (std::isinf(value)) return value;
  workspace_->factor.invert();
  workspace_->factor.gradient(derivatives);
  return value;
}

Eigen::Index GaussianProcessLikelihood::size() const { return workspace_->factor.size(); }
Eigen::Index GaussianProcessLikelihood::dimensions() const { return workspace_->factor.dimensions(); }

}  // namespace lfdcore
