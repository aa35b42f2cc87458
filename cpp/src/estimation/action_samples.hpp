// The samples of an action model: checked, and ordered so that those of one goal stand together.
#pragma once

#include <vector>

#include "gaussian_blocks.hpp"
#include "lfdcore/estimation/action_model.hpp"

namespace lfdcore::detail {

// Throws std::invalid_argument for what no action model can use.
void check_action_data(const RowMatrix& states, const RowMatrix& goals, const RowMatrix& actions,
                       const std::vector<ActionKernel>& kernels);
// Throws std::invalid_argument for indices outside [0, count) and for one named twice.
void check_subset(const std::vector<std::int64_t>& subset, Eigen::Index count);

// State and goal side by side, one row a sample of `chosen`.
RowMatrix joint_inputs(const RowMatrix& states, const RowMatrix& goals, const std::vector<Eigen::Index>& chosen);
Eigen::VectorXd joint_lengthscales(const ActionKernel& kernel);

// Inputs divided by the length-scales in blocks of (dims, 32), padded with zeros.
std::vector<double> scaled_blocks(const RowMatrix& inputs, const Eigen::VectorXd& lengthscales);

// (N, D) -> values[d * padded + n], padded with zeros to blocks of 32.
std::vector<double> padded_columns(const RowMatrix& rows);

inline int blocks_of(Eigen::Index count) { return static_cast<int>((count + lanes - 1) / lanes); }

struct SharedGoals {
  RowMatrix goals;                   // (L, Dg), each once
  std::vector<Eigen::Index> number;  // of each sample's goal
};
SharedGoals shared_goals(const RowMatrix& goals);

}  // namespace lfdcore::detail
