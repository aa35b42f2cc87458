#include "../../../cpp/src/estimation/packed_triangle.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <random>

namespace lfdcore {
namespace {

using Eigen::MatrixXd;

TEST(PackedTriangle, is_factorised_and_inverted_as_eigen_does) {
  const auto kernels = detail::block_kernels_of_this_cpu().back();
  for (const int blocks : {1, 3, 4, 5, 9}) {
    const int N = blocks * detail::lanes;
    std::mt19937 generator(3);
    std::normal_distribution<double> normal;
    const MatrixXd half = MatrixXd::NullaryExpr(N, N, [&] { return normal(generator); });
    const MatrixXd A = half * half.transpose() / N + MatrixXd::Identity(N, N);
    detail::PackedTriangle triangle(blocks);
    using Block = Eigen::Map<Eigen::Matrix<double, detail::lanes, detail::lanes>>;
    const auto fill = [&](const MatrixXd& from) {
      for (int row = 0; row < blocks; ++row)
        for (int column = 0; column <= row; ++column)
          Block(triangle.block(row, column)) = from.block<32, 32>(row * 32, column * 32);
    };
    const auto error = [&](const MatrixXd& to) {
      double largest = 0;
      for (int row = 0; row < blocks; ++row)
        for (int column = 0; column <= row; ++column) {
          const MatrixXd apart = Block(triangle.block(row, column)) - to.block<32, 32>(row * 32, column * 32);
          largest = std::max(largest, apart.cwiseAbs().maxCoeff());
        }
      return largest;
    };
    fill(A);
    const MatrixXd L = A.llt().matrixL();
    EXPECT_EQ(detail::factor(triangle, kernels), -1);
    EXPECT_LT(error(L), 1e-12);
    detail::invert(triangle, kernels);
    detail::transpose_blocks(triangle);
    EXPECT_LT(error(L.inverse()), 1e-12);
    detail::transpose_blocks(triangle);
    detail::gram(triangle, kernels);
    EXPECT_LT(error(A.inverse()), 1e-12);
    MatrixXd singular = A;
    singular.row(N - 1) = singular.row(0);
    singular.col(N - 1) = singular.col(0);
    fill(singular);
    EXPECT_EQ(detail::factor(triangle, kernels), N - 1);
  }
}

}  // namespace
}  // namespace lfdcore
