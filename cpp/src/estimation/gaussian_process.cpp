#include "lfdcore/estimation/gaussian_process.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "gaussian_factor.hpp"
#include "lfdcore/error.hpp"

namespace lfdcore {

using detail::block_size;
using detail::lanes;

namespace {

// An infinite query has no moments: made NaN, which stays so to the end.
double scale(double query, double lengthscale) {
  return std::isfinite(query) ? query / lengthscale : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

struct GaussianProcess::Conditioned {
  Kernel kernel;
  double noise;
  detail::GaussianFactor factor;
  double log_likelihood = 0;
  std::vector<double> inverse;  // L^-1 in panels of block rows, laid out as L is

  double variance() const { return kernel.amplitude * kernel.amplitude; }
  const double* inverse_panel(int row) const { return inverse.data() + std::size_t(row) * (row + 1) / 2 * block_size; }

  void condition();
  void query_one(const double* scaled, double* covariances, double& mean, double& variance) const;
  void query_block(const double* scaled, double* panel, double* mean, double* variance) const;
};

void GaussianProcess::Conditioned::condition() {
  const std::span<const double> lengthscales(kernel.lengthscales.data(), std::size_t(kernel.lengthscales.size()));
  log_likelihood = factor.factor({kernel.family, kernel.amplitude, lengthscales, noise});
  require(factor.failed_sample() < 0, "the covariance is not positive definite at sample " +
                                          std::to_string(factor.failed_sample()) +
                                          ": raise the noise, or drop duplicate inputs, or shorten the length-scales");
  factor.invert();
  inverse.resize(std::size_t(factor.blocks()) * (factor.blocks() + 1) / 2 * block_size);
  double* block = inverse.data();
  for (int row = 0; row < factor.blocks(); ++row)
    for (int column = 0; column <= row; ++column, block += block_size) {
      const double* from = factor.upper(column) + std::size_t(row) * block_size;
      for (int k = 0; k < lanes; ++k)
        for (int i = 0; i < lanes; ++i) block[k * lanes + i] = from[i * lanes + k];
    }
}

// C.4 for one query, (D, 32) of which the first column is used: v = L^-1 k*, mean = k*' K^-1 Y, variance = a^2 - v'v
void GaussianProcess::Conditioned::query_one(const double* scaled, double* covariances, double& mean,
                                             double& spread) const {
  double sum = 0, explained = 0;
  for (int row = 0; row < factor.blocks(); ++row) {
    double* here = covariances + std::size_t(row) * lanes;
    factor.kernels().covariance(kernel.family, variance(), factor.scaled(row), scaled, factor.dimensions(), 1, here,
                                nullptr);
    std::fill(here + factor.used(row), here + lanes, 0.0);
    for (int i = 0; i < lanes; ++i) sum += here[i] * factor.weights()[row * lanes + i];
    std::array<double, lanes> whitened{};
    factor.kernels().accumulate(whitened.data(), inverse_panel(row), covariances, (row + 1) * lanes);
    for (const double v : whitened) explained += v * v;
  }
  mean = sum;
  spread = std::isnan(explained) ? explained : std::max(0.0, variance() - explained);
}

// The same for 32 queries at once: the rows V of V L' = K*, block by block.
void GaussianProcess::Conditioned::query_block(const double* scaled, double* panel, double* mean,
                                               double* spread) const {
  std::array<double, lanes> explained{};
  std::fill_n(mean, lanes, 0.0);
  for (int column = 0; column < factor.blocks(); ++column) {
    double* block = panel + std::size_t(column) * block_size;
    factor.kernels().covariance(kernel.family, variance(), scaled, factor.scaled(column), factor.dimensions(), lanes,
                                block, nullptr);
    std::fill(block + factor.used(column) * lanes, block + block_size, 0.0);
    factor.kernels().accumulate(mean, block, factor.weights() + column * lanes, lanes);
    factor.kernels().subtract(block, panel, factor.lower(column), column * lanes);
    factor.kernels().solve(block, factor.lower(column) + std::size_t(column) * block_size);
    for (int k = 0; k < block_size; ++k) explained[k % lanes] += block[k] * block[k];
  }
  for (int i = 0; i < lanes; ++i)
    spread[i] = std::isnan(explained[i]) ? explained[i] : std::max(0.0, variance() - explained[i]);
}

GaussianProcess::GaussianProcess(const RowMatrix& inputs, const Eigen::VectorXd& targets,
                                 const Eigen::VectorXd& noise_variances, Kernel kernel, double noise) {
  validate(kernel);
  require_between("noise", noise, 0, 1e150, "(a standard deviation)");
  require(inputs.cols() == kernel.lengthscales.size(),
          "inputs have " + std::to_string(inputs.cols()) + " columns, the kernel has " +
              std::to_string(kernel.lengthscales.size()) + " length-scales");
  auto data =
      std::make_shared<Conditioned>(Conditioned{std::move(kernel), noise, {inputs, targets, noise_variances}, 0, {}});
  data->condition();
  data_ = std::move(data);
}

void GaussianProcess::predict(std::span<const double> query, std::span<double> scratch, double& mean,
                              double& variance) const {
  require(query.size() == std::size_t(dimensions()), "a query must have one value for every input dimension");
  require(scratch.size() >= scratch_size(), "the scratch is smaller than scratch_size()");
  const auto scaled = scratch.first(query.size() * lanes);
  for (std::size_t d = 0; d < query.size(); ++d)
    scaled[d * lanes] = scale(query[d], data_->kernel.lengthscales[Eigen::Index(d)]);
  data_->query_one(scaled.data(), scratch.data() + scaled.size(), mean, variance);
}

std::size_t GaussianProcess::scratch_size() const { return std::size_t(dimensions() + data_->factor.blocks()) * lanes; }

GaussianMoments GaussianProcess::predict(const RowMatrix& queries, bool with_noise) const {
  const Eigen::Index M = queries.rows(), D = dimensions();
  require(queries.cols() == D,
          "queries have " + std::to_string(queries.cols()) + " columns, the training inputs " + std::to_string(D));
  const detail::SubnormalsFlushed flushed;
  GaussianMoments moments{Eigen::VectorXd(M), Eigen::VectorXd(M)};
  constexpr Eigen::Index few = 4;  // from here on 32 at once cost less
  if (M <= few) {
    std::vector<double> scratch(scratch_size());
    for (Eigen::Index i = 0; i < M; ++i)
      predict({queries.row(i).data(), std::size_t(D)}, scratch, moments.mean(i), moments.variance(i));
  } else {
    std::vector<double> scaled(std::size_t(D) * lanes), panel(std::size_t(data_ -> factor.blocks()) * block_size);
    std::array<double, lanes> mean, variance;
    for (Eigen::Index first = 0; first < M; first += lanes) {
      const Eigen::Index count = std::min<Eigen::Index>(lanes, M - first);
      for (Eigen::Index d = 0; d < D; ++d)
        for (Eigen::Index i = 0; i < count; ++i)
          scaled[std::size_t(d * lanes + i)] = scale(queries(first + i, d), data_->kernel.lengthscales[d]);
      data_->query_block(scaled.data(), panel.data(), mean.data(), variance.data());
      std::copy_n(mean.data(), count, moments.mean.data() + first);
      std::copy_n(variance.data(), count, moments.variance.data() + first);
    }
  }
  if (with_noise) moments.variance.array() += noise() * noise();
  return moments;
}

Eigen::Index GaussianProcess::size() const { return data_->factor.size(); }
Eigen::Index GaussianProcess::dimensions() const { return data_->factor.dimensions(); }
const Kernel& GaussianProcess::kernel() const { return data_->kernel; }
double GaussianProcess::noise() const { return data_->noise; }
double GaussianProcess::log_likelihood() const { return data_->log_likelihood; }

}  // namespace lfdcore
