// One action's part of Alg. 1: A = s^2 K + K'K, of which only the columns of the selected samples are ever formed.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "action_samples.hpp"
#include "packed_triangle.hpp"

namespace lfdcore::detail {

// With A_SS = L L', b = K'y and w_i = L^-1 A_Si: gain_i = (b_i - w_i'L^-1 b_S)^2 / (2 (A_ii - w_i'w_i)) (ERRATA 11).
// Selected samples are "recent" until there are 96; then w of all samples is extended by them at once ("settled"), so
// that K is formed once for 96 columns of A, 32 of its own columns at a time.
class GreedyBasis {
 public:
  // What is known of 32 samples, in lanes: values[... * 32 + lane].
  struct Lanes {
    int count = 0;
    std::array<Eigen::Index, lanes> samples{};
    std::array<double, lanes> gain{}, schur{}, residual{};  // schur: A_ii - w_i'w_i, residual: b_i - w_i'L^-1 b_S
    std::vector<double> inputs, columns;                    // (dims, 32); of K, (N, 32)
    std::vector<double> settled, recent;                    // parts of w: (size, 32), (96, 32)
    std::vector<double> low, high;                          // the box around the inputs, (dims,)
  };

  // `size`: the most samples that will be selected.
  GreedyBasis(const RowMatrix& inputs, const Eigen::VectorXd& actions, const ActionKernel& kernel, int size);

  Lanes make_lanes() const;
  // Fills `lanes` for up to 32 samples.
  void evaluate(const Eigen::Index* samples, int count, Lanes& lanes) const;
  // Adds a sample of what was evaluated last to the basis, unless it gains nothing.
  void select(const Lanes& lanes, int lane);

 private:
  static constexpr int panels = 3, most_recent = panels * lanes;

  void load(const Eigen::Index* samples, int count, Lanes& lanes) const;
  void form_columns(int first_block, int last_block, Lanes& lanes) const;
  void start();
  bool far_from(const Lanes& lanes, int block) const;
  void recent_columns(Lanes& lanes) const;
  void eliminate(Lanes& lanes) const;
  void settle();
  bool gains(const Lanes& lanes, int lane) const;
  const double* block_inputs(int block) const { return inputs_.data() + std::size_t(block) * dims_ * lanes; }
  int used(int block) const { return static_cast<int>(std::min<Eigen::Index>(lanes, count_ - block * lanes)); }

  BlockKernels kernels_;
  Eigen::Index count_;
  int dims_, blocks_, size_, settled_count_ = 0, recent_count_ = 0;
  double variance_, noise_variance_;
  Eigen::VectorXd actions_;
  std::vector<double> inputs_;                       // scaled, blocks of (dims, 32)
  std::vector<double> diagonal_, schur_, residual_;  // (N,): A_ii; schur and residual after what is settled
  std::vector<double> low_, high_;                   // the box around each block's inputs, (blocks, dims)
  std::vector<double> settled_;                      // (N, size)
  // of the recent samples, in panels of 32: columns of K (N, 32), inputs (dims, 32), the settled part of w (size, 32)
  std::array<std::vector<double>, panels> recent_columns_, recent_inputs_, recent_settled_;
  std::array<double, most_recent * most_recent> recent_lower_{};  // L among them, row-major
  std::array<double, most_recent> recent_explained_{};            // their elements of L^-1 b
};

}  // namespace lfdcore::detail
