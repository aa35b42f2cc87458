#include "action_output.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "lfdcore/error.hpp"
#include "lfdcore/estimation/kernel.hpp"

namespace lfdcore::detail {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// A basis sample adds only rounding errors where the others leave less than this share of its variance.
constexpr double spanned_share = 1e-10;

double square(double x) { return x * x; }

ActionOutput start(const RowMatrix& inputs, const std::vector<Index>& numbers, const ActionKernel& kernel, int goals) {
  ActionOutput output;
  output.count = inputs.rows();
  output.dims = static_cast<int>(inputs.cols());
  output.blocks = blocks_of(inputs.rows());
  output.inputs = scaled_blocks(inputs, joint_lengthscales(kernel));
  output.weights.assign(output.padded(), 0.0);
  for (int goal = 0; goals > 0 && goal <= goals; ++goal)
    output.starts.push_back(std::ranges::lower_bound(numbers, goal) - numbers.begin());
  if (goals > 0) return output;
  output.goals = padded_columns(inputs.rightCols(kernel.goal_lengthscales.size()));
  return output;
}

// K + s^2 I (C.5); the padding has variance 1 and no covariance.
void fill(ActionOutput& output, const ActionKernel& kernel, const BlockKernels& kernels) {
  const int blocks = output.blocks, used = static_cast<int>(output.count) - (blocks - 1) * lanes;
  for (int row = 0; row < blocks; ++row)
    for (int column = 0; column <= row; ++column)
      kernels.covariance(KernelFamily::squared_exponential, square(kernel.amplitude), output.block_inputs(row),
                         output.block_inputs(column), output.dims, lanes, output.triangle.block(row, column), nullptr);
  for (int column = 0; column < blocks; ++column)
    for (int j = 0; j < lanes; ++j)
      std::fill_n(output.triangle.block(blocks - 1, column) + j * lanes + used, lanes - used, 0.0);
  double* last = output.triangle.block(blocks - 1, blocks - 1);
  for (int j = used; j < lanes; ++j) std::fill_n(last + j * lanes, lanes, 0.0);
  for (int block = 0; block < blocks; ++block)
    for (int i = 0; i < lanes; ++i)
      output.triangle.block(block, block)[i * lanes + i] +=
          block * lanes + i < output.count ? square(kernel.noise) : 1.0;
}

// beta = M'(M y) over M = L^-1 with transposed blocks
void weigh(ActionOutput& output, const VectorXd& actions) {
  VectorXd padded = VectorXd::Zero(static_cast<Index>(output.padded())), whitened = padded;
  padded.head(output.count) = actions;
  Eigen::Map<VectorXd> weights(output.weights.data(), padded.size());
  using Block = Eigen::Map<const Eigen::Matrix<double, lanes, lanes, Eigen::RowMajor>>;
  for (int row = 0; row < output.blocks; ++row)
    for (int column = 0; column <= row; ++column)
      whitened.segment<lanes>(row * lanes) +=
          Block(output.triangle.block(row, column)) * padded.segment<lanes>(column * lanes);
  for (int row = 0; row < output.blocks; ++row)
    for (int column = 0; column <= row; ++column)
      weights.segment<lanes>(column * lanes) +=
          Block(output.triangle.block(row, column)).transpose() * whitened.segment<lanes>(row * lanes);
  weights.tail(padded.size() - output.count).setZero();
}

// A basis without the samples that others of it span: a Cholesky factorisation that takes the largest pivot next.
std::vector<Index> independent(const RowMatrix& inputs, const std::vector<Index>& basis, const Kernel& kernel) {
  const RowMatrix chosen = inputs(basis, Eigen::all);
  const MatrixXd K = covariance(kernel, chosen, chosen);
  MatrixXd L(K.rows(), K.rows());
  VectorXd left = K.diagonal();
  std::vector<Index> kept;
  for (Index t = 0; t < K.rows(); ++t) {
    Index i = 0;
    const double pivot = left.maxCoeff(&i);
    if (!(pivot > spanned_share * square(kernel.amplitude))) break;
    L.col(t) = (K.col(i) - L.leftCols(t) * L.row(i).head(t).transpose()) / std::sqrt(pivot);
    left -= L.col(t).cwiseAbs2();
    kept.push_back(basis[static_cast<std::size_t>(i)]);
  }
  std::ranges::sort(kept);
  return kept;
}

// Lower triangular R with R'R = A'A
MatrixXd lower_factor(const MatrixXd& A) {
  const Eigen::HouseholderQR<MatrixXd> qr(A.rowwise().reverse());
  const MatrixXd upper = qr.matrixQR().triangularView<Eigen::Upper>();
  return upper.reverse();
}

void pack(const MatrixXd& lower, PackedTriangle& triangle) {
  for (int row = 0; row < triangle.blocks(); ++row)
    for (int column = 0; column <= row; ++column) {
      const Index i = row * lanes, j = column * lanes;
      const Index height = std::min<Index>(lanes, lower.rows() - i), width = std::min<Index>(lanes, lower.cols() - j);
      Eigen::Map<MatrixXd>(triangle.block(row, column), lanes, lanes).topLeftCorner(height, width) =
          lower.block(i, j, height, width);
    }
}

}  // namespace

std::size_t ActionOutput::bytes() const {
  return triangle.bytes() + (inputs.size() + weights.size() + goals.size()) * sizeof(double) +
         starts.size() * sizeof(Index);
}

ActionOutput condition(const ActionSamples& samples, const ActionKernel& kernel, int goals) {
  const BlockKernels kernels = block_kernels_of_this_cpu().back();
  ActionOutput output = start(samples.inputs, samples.goals, kernel, goals);
  output.triangle = PackedTriangle(output.blocks);
  fill(output, kernel, kernels);
  require(factor(output.triangle, kernels) < 0,
          "the covariance of the samples is not positive definite: raise a kernel's noise, or drop duplicate samples");
  invert(output.triangle, kernels);
  weigh(output, samples.actions);
  output.largest_inverse = kernel.noise > 0 ? 1 / square(kernel.noise) : std::numeric_limits<double>::infinity();
  if (goals > 0)
    transpose_blocks(output.triangle);
  else
    gram(output.triangle, kernels);
  return output;
}

// With L L' = K_SS, V = L^-1 K_SN, V V' = U E U': beta = L^-T U (E + s^2)^-1 U' V y and
// D = R'R, R = (E / (E + s^2))^(1/2) U' L^-1: a sum of squares, which stays exact where K_SS^-1 is large.
ActionOutput project(const ActionSamples& samples, const std::vector<Index>& basis, const ActionKernel& kernel,
                     int goals) {
  const Kernel joint{KernelFamily::squared_exponential, kernel.amplitude, joint_lengthscales(kernel)};
  const std::vector<Index> kept = independent(samples.inputs, basis, joint);
  const RowMatrix chosen = samples.inputs(kept, Eigen::all);
  std::vector<Index> numbers;
  for (const Index i : kept) numbers.push_back(samples.goals[static_cast<std::size_t>(i)]);
  ActionOutput output = start(chosen, numbers, kernel, goals);

  const Index S = chosen.rows(), N = samples.inputs.rows(), step = 1024;
  const Eigen::LLT<MatrixXd> factor(covariance(joint, chosen, chosen));
  MatrixXd VV = MatrixXd::Zero(S, S);
  VectorXd Vy = VectorXd::Zero(S);
  for (Index first = 0; first < N; first += step) {
    const Index count = std::min(step, N - first);
    MatrixXd V = covariance(joint, chosen, samples.inputs.middleRows(first, count));
    factor.matrixL().solveInPlace(V);
    VV.selfadjointView<Eigen::Lower>().rankUpdate(V);
    Vy += V * samples.actions.segment(first, count);
  }
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(VV);
  const Eigen::ArrayXd E = eigen.eigenvalues().array().max(std::numeric_limits<double>::min());
  const Eigen::ArrayXd noisy = E + square(kernel.noise);
  const VectorXd weights =
      factor.matrixU().solve(eigen.eigenvectors() * ((eigen.eigenvectors().transpose() * Vy).array() / noisy).matrix());
  std::ranges::copy(weights, output.weights.begin());
  MatrixXd R = eigen.eigenvectors().transpose();
  factor.matrixL().solveInPlace<Eigen::OnTheRight>(R);
  R = lower_factor((E / noisy).sqrt().matrix().asDiagonal() * R);
  output.largest_inverse = R.squaredNorm();
  output.triangle = PackedTriangle(output.blocks);
  pack(goals > 0 ? R : MatrixXd(R.transpose() * R), output.triangle);
  return output;
}

}  // namespace lfdcore::detail
