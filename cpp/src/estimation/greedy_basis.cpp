#include "greedy_basis.hpp"

#include <algorithm>
#include <cmath>

namespace lfdcore::detail {
namespace {

constexpr double spanned_share = 1e-10;  // ERRATA 13
constexpr double far_square = 92;        // covariances below 1e-20 of the variance are rounding error beside others

// The box around the first `count` lanes of inputs (dims, 32).
void enclose(const double* inputs, int dims, int count, double* low, double* high) {
  for (int d = 0; d < dims; ++d) {
    const auto [least, most] = std::minmax_element(inputs + d * lanes, inputs + d * lanes + count);
    low[d] = *least;
    high[d] = *most;
  }
}

}  // namespace

GreedyBasis::GreedyBasis(const RowMatrix& inputs, const Eigen::VectorXd& actions, const ActionKernel& kernel, int size)
    : kernels_(block_kernels_of_this_cpu().back()),
      count_(inputs.rows()),
      dims_(static_cast<int>(inputs.cols())),
      blocks_(blocks_of(inputs.rows())),
      size_(size),
      variance_(kernel.amplitude * kernel.amplitude),
      noise_variance_(kernel.noise * kernel.noise),
      actions_(actions),
      inputs_(scaled_blocks(inputs, joint_lengthscales(kernel))),
      diagonal_(static_cast<std::size_t>(count_)),
      residual_(static_cast<std::size_t>(count_)),
      low_(std::size_t(blocks_) * dims_),
      high_(low_.size()),
      settled_(static_cast<std::size_t>(count_) * size) {
  for (int p = 0; p < panels; ++p) {
    recent_columns_[p].resize(static_cast<std::size_t>(count_) * lanes);
    recent_inputs_[p].resize(std::size_t(dims_) * lanes);
    recent_settled_[p].resize(std::size_t(size_) * lanes);
  }
  for (int block = 0; block < blocks_; ++block)
    enclose(block_inputs(block), dims_, used(block), low_.data() + block * dims_, high_.data() + block * dims_);
  start();
}

GreedyBasis::Lanes GreedyBasis::make_lanes() const {
  Lanes made;
  made.inputs.resize(std::size_t(dims_) * lanes);
  made.columns.resize(static_cast<std::size_t>(count_) * lanes);
  made.settled.resize(std::size_t(size_) * lanes);
  made.recent.resize(most_recent * lanes);
  made.low.resize(static_cast<std::size_t>(dims_));
  made.high.resize(static_cast<std::size_t>(dims_));
  return made;
}

// A_ii = s^2 k_ii + |K_i|^2 and b_i = K_i'y
void GreedyBasis::start() {
  Lanes all = make_lanes();
  for (int block = 0; block < blocks_; ++block) {
    std::copy_n(block_inputs(block), all.inputs.size(), all.inputs.begin());
    form_columns(0, blocks_, all);
    std::array<double, lanes> squares{}, products{};
    for (Eigen::Index k = 0; k < count_; ++k)
      for (int i = 0; i < lanes; ++i) squares[i] += all.columns[k * lanes + i] * all.columns[k * lanes + i];
    kernels_.accumulate(products.data(), all.columns.data(), actions_.data(), static_cast<int>(count_));
    for (int i = 0; i < used(block); ++i) {
      diagonal_[std::size_t(block) * lanes + i] = noise_variance_ * variance_ + squares[i];
      residual_[std::size_t(block) * lanes + i] = products[i];
    }
  }
  schur_ = diagonal_;
}

void GreedyBasis::load(const Eigen::Index* samples, int count, Lanes& to) const {
  to.count = count;
  std::ranges::fill(to.inputs, 0.0);
  for (int lane = 0; lane < count; ++lane) {
    const auto i = static_cast<std::size_t>(samples[lane]);
    to.samples[lane] = samples[lane];
    to.schur[lane] = schur_[i];
    to.residual[lane] = residual_[i];
    const double* inputs = block_inputs(static_cast<int>(i / lanes)) + i % lanes;
    for (int d = 0; d < dims_; ++d) to.inputs[d * lanes + lane] = inputs[d * lanes];
    for (int t = 0; t < settled_count_; ++t) to.settled[t * lanes + lane] = settled_[i * size_ + t];
  }
  enclose(to.inputs.data(), dims_, count, to.low.data(), to.high.data());
}

bool GreedyBasis::far_from(const Lanes& of, int block) const {
  const double *low = low_.data() + block * dims_, *high = high_.data() + block * dims_;
  double square = 0;
  for (int d = 0; d < dims_; ++d) {
    const double gap = std::max({0.0, low[d] - of.high[d], of.low[d] - high[d]});
    square += gap * gap;
  }
  return square > far_square;
}

void GreedyBasis::form_columns(int first_block, int last_block, Lanes& of) const {
  for (int block = first_block; block < last_block; ++block)
    kernels_.covariance(KernelFamily::squared_exponential, variance_, of.inputs.data(), block_inputs(block), dims_,
                        used(block), of.columns.data() + std::size_t(block) * block_size, nullptr);
}

// recent <- A_is - (settled parts of w_i'w_s), s the recent samples
void GreedyBasis::recent_columns(Lanes& of) const {
  std::array<double, block_size> near;
  const int used_panels = (recent_count_ + lanes - 1) / lanes;
  std::ranges::fill(of.recent, 0.0);
  for (int block = 0; block < blocks_; ++block) {
    const std::size_t at = std::size_t(block) * block_size;
    if (far_from(of, block)) {
      std::fill_n(of.columns.begin() + at, used(block) * lanes, 0.0);
      continue;
    }
    form_columns(block, block + 1, of);
    for (int p = 0; p < used_panels; ++p)
      kernels_.subtract(of.recent.data() + p * block_size, of.columns.data() + at, recent_columns_[p].data() + at,
                        used(block));
  }
  for (int p = 0; p < used_panels; ++p) {
    double* block = of.recent.data() + p * block_size;
    kernels_.covariance(KernelFamily::squared_exponential, variance_, of.inputs.data(), recent_inputs_[p].data(), dims_,
                        lanes, near.data(), nullptr);
    for (int i = 0; i < block_size; ++i) block[i] = noise_variance_ * near[i] - block[i];
    subtract_deep(kernels_, block, of.settled.data(), recent_settled_[p].data(), settled_count_);
  }
}

// recent <- L^-1 of it, and what that leaves of A_ii and b_i
void GreedyBasis::eliminate(Lanes& of) const {
  for (int r = 0; r < recent_count_; ++r) {
    double* w = of.recent.data() + r * lanes;
    const double* L = recent_lower_.data() + r * most_recent;
    for (int q = 0; q < r; ++q)
      for (int i = 0; i < lanes; ++i) w[i] -= L[q] * of.recent[q * lanes + i];
    for (int i = 0; i < lanes; ++i) {
      w[i] /= L[r];
      of.schur[i] -= w[i] * w[i];
      of.residual[i] -= w[i] * recent_explained_[r];
    }
  }
}

bool GreedyBasis::gains(const Lanes& of, int lane) const {
  return of.schur[lane] > spanned_share * diagonal_[static_cast<std::size_t>(of.samples[lane])];
}

void GreedyBasis::evaluate(const Eigen::Index* samples, int count, Lanes& to) const {
  load(samples, count, to);
  recent_columns(to);
  eliminate(to);
  for (int i = 0; i < count; ++i) to.gain[i] = gains(to, i) ? to.residual[i] * to.residual[i] / (2 * to.schur[i]) : 0;
}

void GreedyBasis::select(const Lanes& from, int lane) {
  if (!gains(from, lane)) return;
  const int r = recent_count_++, p = r / lanes, j = r % lanes;
  for (Eigen::Index k = 0; k < count_; ++k) recent_columns_[p][k * lanes + j] = from.columns[k * lanes + lane];
  for (int d = 0; d < dims_; ++d) recent_inputs_[p][d * lanes + j] = from.inputs[d * lanes + lane];
  for (int t = 0; t < settled_count_; ++t) recent_settled_[p][t * lanes + j] = from.settled[t * lanes + lane];
  for (int q = 0; q < r; ++q) recent_lower_[r * most_recent + q] = from.recent[q * lanes + lane];
  recent_lower_[r * most_recent + r] = std::sqrt(from.schur[lane]);
  recent_explained_[r] = from.residual[lane] / std::sqrt(from.schur[lane]);
  if (recent_count_ == most_recent) settle();
}

void GreedyBasis::settle() {
  Lanes all = make_lanes();
  std::array<Eigen::Index, lanes> samples;
  for (int block = 0; block < blocks_; ++block) {
    for (int i = 0; i < lanes; ++i) samples[i] = block * lanes + i;
    evaluate(samples.data(), used(block), all);
    for (int i = 0; i < used(block); ++i) {
      const auto n = std::size_t(block) * lanes + i;
      for (int r = 0; r < recent_count_; ++r) settled_[n * size_ + settled_count_ + r] = all.recent[r * lanes + i];
      schur_[n] = all.schur[i];
      residual_[n] = all.residual[i];
    }
  }
  settled_count_ += recent_count_;
  recent_count_ = 0;
}

}  // namespace lfdcore::detail
