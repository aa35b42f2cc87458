// The matrix type of the estimators' inputs.
#pragma once

#include <Eigen/Core>

namespace lfdcore {

/// (N, D): one input a row, as NumPy has it.
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace lfdcore
