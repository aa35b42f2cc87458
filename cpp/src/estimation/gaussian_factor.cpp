#include "gaussian_factor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <string>

#include "lfdcore/error.hpp"

namespace lfdcore::detail {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
// A pivot below this share of its diagonal element is rounding error.
constexpr double pivot_share = 1e-13;
const double half_log_two_pi = 0.5 * std::log(2 * std::numbers::pi);

void check_data(const RowMatrix& inputs, const Eigen::VectorXd& targets, const Eigen::VectorXd& noise) {
  require(inputs.rows() > 0 && inputs.cols() > 0, "a Gaussian process needs at least one training input, got shape (" +
                                                      std::to_string(inputs.rows()) + ", " +
                                                      std::to_string(inputs.cols()) + ")");
  require(inputs.rows() == targets.size() && inputs.rows() == noise.size(),
          std::to_string(inputs.rows()) + " training inputs but " + std::to_string(targets.size()) + " targets and " +
              std::to_string(noise.size()) + " noise variances");
  require(inputs.allFinite() && targets.allFinite(), "training inputs and targets must be finite");
  require(targets.cwiseAbs().maxCoeff() <= 1e150, "targets must lie within +-1e150, whose squares are numbers");
  require(noise.allFinite() && noise.minCoeff() >= 0, "noise variances must be finite and not negative");
}

// Fisher-Yates with a generator of its own (MMIX's): the same order on every platform.
std::vector<Eigen::Index> mixed_order(Eigen::Index count) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::uint64_t state = 1;
  for (std::size_t i = order.size(); i > 1; --i) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    std::swap(order[i - 1], order[(state >> 33) % i]);
  }
  return order;
}

// sum_ij weight[j][i] (row_i - column_j)^2
double weighted_squares(const double* weight, const double* row, const double* column) {
  double sum = 0;
  for (int j = 0; j < lanes; ++j)
    for (int i = 0; i < lanes; ++i) sum += weight[j * lanes + i] * (row[i] - column[j]) * (row[i] - column[j]);
  return sum;
}

}  // namespace

GaussianFactor::GaussianFactor(const RowMatrix& inputs, const Eigen::VectorXd& targets,
                               const Eigen::VectorXd& noise_variances, const BlockKernels& kernels)
    : kernels_(kernels), count_(inputs.rows()), dims_(static_cast<int>(inputs.cols())) {
  check_data(inputs, targets, noise_variances);
  order_ = mixed_order(count_);
  blocks_ = static_cast<int>((count_ + lanes - 1) / lanes);
  const auto padded = std::size_t(blocks_) * lanes;
  inputs_.resize(padded * dims_);
  targets_.resize(padded);
  variances_.resize(padded);
  for (std::size_t i = 0; i < order_.size(); ++i) {
    targets_[i] = targets(order_[i]);
    variances_[i] = noise_variances(order_[i]);
    for (int d = 0; d < dims_; ++d) inputs_[(i / lanes * dims_ + d) * lanes + i % lanes] = inputs(order_[i], d);
  }
  scaled_.resize(inputs_.size());
  lower_.resize(std::size_t(blocks_) * (blocks_ + 1) / 2 * block_size);
  whitened_.resize(padded);
  weights_.resize(padded);
  values_.resize(block_size);
  slopes_.resize(block_size);
}

void GaussianFactor::scale_inputs(std::span<const double> lengthscales) {
  for (std::size_t i = 0; i < scaled_.size(); ++i)
    scaled_[i] = inputs_[i] / lengthscales[i / lanes % static_cast<std::size_t>(dims_)];
}

void GaussianFactor::covariance(int row, int column, double* values, double* slopes) const {
  kernels_.covariance(scales_.family, scales_.amplitude * scales_.amplitude, scaled(row), scaled(column), dims_, lanes,
                      values, slopes);
  clear_padding(row, column, values);
  if (slopes) clear_padding(row, column, slopes);
}

// The padding has no covariance with anything. Only the last block row has any, and in its last column only.
void GaussianFactor::clear_padding(int row, int column, double* block) const {
  const int rows = used(row), columns = used(column);
  for (int j = 0; j < lanes && (rows < lanes || columns < lanes); ++j)
    std::fill(block + j * lanes + (j < columns ? rows : 0), block + (j + 1) * lanes, 0.0);
}

// K + diag(var_n + s^2), ERRATA 33; the padding has variance 1 and target 0, so it adds nothing to C.3.
void GaussianFactor::add_noise(int row, double* diagonal) const {
  for (int i = 0; i < lanes; ++i) {
    const auto n = std::size_t(row) * lanes + i;
    diagonal[i * lanes + i] += i < used(row) ? variances_[n] + scales_.noise * scales_.noise : 1;
  }
}

bool GaussianFactor::factor_row(int row) {
  double* panel = lower_.data() + std::size_t(row) * (row + 1) / 2 * block_size;
  for (int column = 0; column <= row; ++column) {
    double* block = panel + std::size_t(column) * block_size;
    covariance(row, column, block, nullptr);
    if (column == row) add_noise(row, block);
    std::array<double, lanes> smallest;
    for (int i = 0; i < lanes && column == row; ++i) smallest[i] = pivot_share * block[i * lanes + i];
    kernels_.subtract(block, panel, lower(column), column * lanes);
    if (column < row) {
      kernels_.solve(block, lower(column) + std::size_t(column) * block_size);
    } else if (const int i = kernels_.factor(block, smallest.data()); i < lanes) {
      failed_ = order_[std::size_t(row) * lanes + i];
      return false;
    }
  }
  return true;
}

// log p of this block row's samples given those before.
double GaussianFactor::explain_row(int row) {
  const double* panel = lower(row);
  const double* diagonal = panel + std::size_t(row) * block_size;
  std::array<double, lanes> known{};
  kernels_.accumulate(known.data(), panel, whitened_.data(), row * lanes);
  double sum = 0;
  for (int i = 0; i < lanes; ++i) {
    const auto n = std::size_t(row) * lanes + i;
    for (int k = 0; k < i; ++k) known[i] += diagonal[k * lanes + i] * whitened_[std::size_t(row) * lanes + k];
    const double pivot = diagonal[i * lanes + i];
    whitened_[n] = (targets_[n] - known[i]) / pivot;
    sum -= 0.5 * whitened_[n] * whitened_[n] + std::log(pivot);
  }
  return sum;
}

// A sample's log density given others is at most that of its noise alone, -log(2 pi v) / 2; here without the 2 pi.
double GaussianFactor::noise_bound(int row) const {
  double sum = 0;
  for (int i = 0; i < used(row); ++i)
    sum -= 0.5 * std::log(variances_[std::size_t(row) * lanes + i] + scales_.noise * scales_.noise);
  return sum;
}

double GaussianFactor::factor(const GaussianScales& scales, double give_up_below) {
  const SubnormalsFlushed flushed;
  scales_ = scales;
  scale_inputs(scales.lengthscales);
  failed_ = -1;
  double open = 0;  // no less than what the rows to come can add
  const bool bounded = give_up_below > -infinity;
  for (int row = 0; bounded && row < blocks_; ++row) open += noise_bound(row);
  double sum = -half_log_two_pi * double(count_);
  for (int row = 0; row < blocks_; ++row) {
    if (!factor_row(row)) return -infinity;
    sum += explain_row(row);
    if (!bounded) continue;
    open -= noise_bound(row);
    if (row + 1 < blocks_ && sum + open < give_up_below) return -infinity;
  }
  return sum;
}

// L^-T: the rows X of X L' = I, which start at the diagonal.
void GaussianFactor::invert() {
  const SubnormalsFlushed flushed;
  upper_.resize(std::size_t(blocks_) * blocks_ * block_size);
  for (int row = 0; row < blocks_; ++row) {
    double* panel = upper_.data() + std::size_t(row) * blocks_ * block_size;
    double* start = panel + std::size_t(row) * block_size;
    for (int column = row; column < blocks_; ++column) {
      double* block = panel + std::size_t(column) * block_size;
      std::fill_n(block, block_size, 0.0);
      for (int i = 0; i < lanes && column == row; ++i) block[i * lanes + i] = 1;
      kernels_.subtract(block, start, lower(column) + std::size_t(row) * block_size, (column - row) * lanes);
      kernels_.solve(block, lower(column) + std::size_t(column) * block_size);
    }
    double* weights = weights_.data() + std::size_t(row) * lanes;
    std::fill_n(weights, lanes, 0.0);
    kernels_.accumulate(weights, start, whitened_.data() + std::size_t(row) * lanes, (blocks_ - row) * lanes);
  }
}

// A block of (w w' - K^-1) / 2, w = K^-1 Y; blocks below the diagonal count twice, for those above.
void GaussianFactor::misfit(int row, int column, double* block) const {
  const auto first = std::size_t(row) * block_size;
  std::fill_n(block, block_size, 0.0);
  kernels_.subtract(block, upper(row) + first, upper(column) + first, (blocks_ - row) * lanes);  // -K^-1
  const double times = row == column ? 0.5 : 1;
  const double* rows = weights_.data() + std::size_t(row) * lanes;
  for (int j = 0; j < lanes; ++j) {
    const double weight = weights_[std::size_t(column) * lanes + j];
    for (int i = 0; i < lanes; ++i) block[j * lanes + i] = times * (block[j * lanes + i] + rows[i] * weight);
  }
}

// d log p / d theta = tr((w w' - K^-1) dK / d theta) / 2
void GaussianFactor::gradient(std::span<double> derivatives) {
  const SubnormalsFlushed flushed;
  std::ranges::fill(derivatives, 0.0);
  std::array<double, block_size> weight;
  const double noise_slope = 2 * scales_.noise * scales_.noise;
  for (int row = 0; row < blocks_; ++row)
    for (int column = 0; column <= row; ++column) {
      misfit(row, column, weight.data());
      for (int i = 0; row == column && i < used(row); ++i) derivatives.back() += noise_slope * weight[i * lanes + i];
      covariance(row, column, values_.data(), slopes_.data());
      for (int i = 0; i < block_size; ++i) derivatives[0] += 2 * weight[i] * values_[i];
      for (int i = 0; i < block_size; ++i) weight[i] *= slopes_[i];
      for (int d = 0; d < dims_; ++d)
        derivatives[std::size_t(d) + 1] +=
            weighted_squares(weight.data(), scaled(row) + d * lanes, scaled(column) + d * lanes);
    }
}

}  // namespace lfdcore::detail
