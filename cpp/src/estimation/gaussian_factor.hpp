// K + noise factorised block row by block row (C.3): what the likelihood and the regression share.
#pragma once

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include "gaussian_blocks.hpp"
#include "lfdcore/estimation/kernel.hpp"

namespace lfdcore::detail {

// Parameters without an allocation.
struct GaussianScales {
  KernelFamily family = KernelFamily::squared_exponential;
  double amplitude = 1;
  std::span<const double> lengthscales;
  double noise = 0;
};

class GaussianFactor {
 public:
  // Inputs (N, D), targets (N,), the samples' own noise variances (N,). Samples are taken in another order (fixed), so
  // that the first block rows already stand for all of them. Throws std::invalid_argument for what no GP can use.
  // `kernels` is for tests: by default the fastest that this CPU runs.
  GaussianFactor(const RowMatrix& inputs, const Eigen::VectorXd& targets, const Eigen::VectorXd& noise_variances,
                 const BlockKernels& kernels = block_kernels_of_this_cpu().back());

  // log p(Y | X) (C.3 with ERRATA 33). -inf if the covariance is not positive definite, and as soon as it is certain
  // that the result is below `give_up_below`. No allocation.
  double factor(const GaussianScales& scales, double give_up_below = -std::numeric_limits<double>::infinity());

  // After factor(): L^-T and K^-1 Y. No allocation from the second call on.
  void invert();
  // After invert(): d log p / d (log a, log l_1 .. log l_D, log noise).
  void gradient(std::span<double> derivatives);

  Eigen::Index size() const { return count_; }
  int dimensions() const { return dims_; }
  Eigen::Index failed_sample() const { return failed_; }  // the sample (as given) whose pivot failed, or -1

  int blocks() const { return blocks_; }
  int used(int block) const { return std::min(lanes, static_cast<int>(count_) - block * lanes); }  // without padding
  const BlockKernels& kernels() const { return kernels_; }
  const double* lower(int row) const { return lower_.data() + std::size_t(row) * (row + 1) / 2 * block_size; }
  // Panel of L^-T: its rows are the block's, blocks left of the diagonal are not written.
  const double* upper(int row) const { return upper_.data() + std::size_t(row) * blocks_ * block_size; }
  const double* scaled(int block) const { return scaled_.data() + std::size_t(block) * dims_ * lanes; }
  const double* weights() const { return weights_.data(); }  // K^-1 Y, padded with zeros

 private:
  void scale_inputs(std::span<const double> lengthscales);
  void covariance(int row, int column, double* values, double* slopes) const;
  void clear_padding(int row, int column, double* block) const;
  void add_noise(int row, double* diagonal) const;
  bool factor_row(int row);
  double explain_row(int row);
  double noise_bound(int row) const;
  void misfit(int row, int column, double* block) const;

  BlockKernels kernels_;
  Eigen::Index count_ = 0;
  int dims_ = 0, blocks_ = 0;
  std::vector<Eigen::Index> order_;
  std::vector<double> inputs_, targets_, variances_;  // in blocks of 32, padded
  std::vector<double> scaled_, lower_, upper_, whitened_, weights_;
  std::vector<double> values_, slopes_;  // one block each
  GaussianScales scales_;
  Eigen::Index failed_ = -1;
};

}  // namespace lfdcore::detail
