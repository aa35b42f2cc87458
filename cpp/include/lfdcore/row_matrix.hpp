// The matrix type of samples.
#pragma once

#include <Eigen/Core>

namespace lfdcore {

/// (N, D): one sample a row, as NumPy has it.
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace lfdcore
