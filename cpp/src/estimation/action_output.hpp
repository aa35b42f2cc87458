// One action's Gaussian process, conditioned: weights beta and D, the matrix under the trace of G_aa (Sec. 2.3).
#pragma once

#include <vector>

#include "action_samples.hpp"
#include "packed_triangle.hpp"

namespace lfdcore::detail {

struct ActionSamples {
  RowMatrix inputs;                 // (N, Dx + Dg), those of one goal together
  Eigen::VectorXd actions;          // (N,)
  std::vector<Eigen::Index> goals;  // the number of each sample's goal, ascending
};

struct ActionOutput {
  Eigen::Index count = 0;
  int dims = 0, blocks = 0;
  std::vector<double> inputs;        // scaled, blocks of (dims, 32)
  std::vector<double> weights;       // beta, padded with zeros
  std::vector<Eigen::Index> starts;  // of the samples of each shared goal, and their end
  std::vector<double> goals;         // where goals are not shared: (Dg, padded), as given
  PackedTriangle triangle{0};        // R with D = R'R; where goals are not shared, D
  double largest_inverse = 0;        // a bound of D's eigenvalues

  std::size_t padded() const { return std::size_t(blocks) * lanes; }
  const double* block_inputs(int block) const { return inputs.data() + std::size_t(block) * dims * lanes; }
  std::size_t bytes() const;
};

// `goals`: how many are shared, 0 if each sample has to be taken with its own.
// beta = (K + s^2 I)^-1 y (ERRATA 1), D = (K + s^2 I)^-1
ActionOutput condition(const ActionSamples& samples, const ActionKernel& kernel, int goals);
// ERRATA 14, DTC over the `basis` S: beta = (s^2 K_SS + K_SN K_NS)^-1 K_SN y,
// D = K_SS^-1 - s^2 (s^2 K_SS + K_SN K_NS)^-1
ActionOutput project(const ActionSamples& samples, const std::vector<Eigen::Index>& basis, const ActionKernel& kernel,
                     int goals);

}  // namespace lfdcore::detail
