#include "packed_triangle.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace lfdcore::detail {
namespace {

// A pivot below this share of its diagonal element is rounding error.
constexpr double pivot_share = 1e-13;
constexpr int chunk = 4 * lanes;  // two panels of this depth stay in the second cache
constexpr int group = 4;          // block rows that share what is read from memory

bool factor_diagonal(double* block, const std::array<double, lanes>& smallest, const BlockKernels& kernels, int& row) {
  row = kernels.factor(block, smallest.data());
  return row == lanes;
}

}  // namespace

void subtract_deep(const BlockKernels& kernels, double* block, const double* rows, const double* columns, int depth) {
  for (int k = 0; k < depth; k += chunk)
    kernels.subtract(block, rows + std::size_t(k) * lanes, columns + std::size_t(k) * lanes,
                     std::min(chunk, depth - k));
}

int factor(PackedTriangle& triangle, const BlockKernels& kernels) {
  const SubnormalsFlushed flushed;
  for (int first = 0; first < triangle.blocks(); first += group) {
    const int last = std::min(first + group, triangle.blocks());
    for (int column = 0; column < last; ++column)
      for (int row = std::max(first, column); row < last; ++row) {
        double* block = triangle.block(row, column);
        std::array<double, lanes> smallest;
        for (int i = 0; i < lanes; ++i) smallest[i] = pivot_share * block[i * lanes + i];
        subtract_deep(kernels, block, triangle.block(row, 0), triangle.block(column, 0), column * lanes);
        int failed = 0;
        if (row > column)
          kernels.solve(block, triangle.block(column, column));
        else if (!factor_diagonal(block, smallest, kernels, failed))
          return row * lanes + failed;
      }
  }
  return -1;
}

// Block row r of M = L^-1: M_rc = -L_rr^-1 sum_{c <= k < r} L_rk M_kc, M_rr = L_rr^-1. All M_kc transposed.
void invert(PackedTriangle& triangle, const BlockKernels& kernels) {
  const SubnormalsFlushed flushed;
  std::vector<double> lower(std::size_t(group) * triangle.blocks() * block_size);
  for (int first = 0; first < triangle.blocks(); first += group) {
    const int last = std::min(first + group, triangle.blocks());
    const auto L = [&](int row, int column) {
      return lower.data() + (std::size_t(row - first) * triangle.blocks() + column) * block_size;
    };
    for (int row = first; row < last; ++row)
      std::copy_n(triangle.block(row, 0), std::size_t(row + 1) * block_size, L(row, 0));
    for (int column = 0; column < last; ++column) {
      const int top = std::max(first, column);
      for (int row = top; row < last; ++row) {
        double* block = triangle.block(row, column);
        std::fill_n(block, block_size, 0.0);
        for (int i = 0; i < lanes && row == column; ++i) block[i * lanes + i] = 1;
      }
      for (int k = column; k < first; ++k)
        for (int row = first; row < last; ++row)
          kernels.subtract(triangle.block(row, column), triangle.block(k, column), L(row, k), lanes);
      for (int row = top; row < last; ++row) {
        for (int k = top; k < row; ++k)
          kernels.subtract(triangle.block(row, column), triangle.block(k, column), L(row, k), lanes);
        kernels.solve(triangle.block(row, column), L(row, row));
      }
    }
  }
}

void gram(PackedTriangle& triangle, const BlockKernels& kernels) {
  const SubnormalsFlushed flushed;
  std::vector<double> panel(std::size_t(triangle.blocks()) * block_size);
  std::array<double, block_size> sum;
  for (int row = 0; row < triangle.blocks(); ++row) {
    std::copy_n(triangle.block(row, 0), std::size_t(row + 1) * block_size, panel.begin());
    for (int column = 0; column <= row; ++column) {
      sum.fill(0);
      kernels.subtract(sum.data(), panel.data() + std::size_t(row) * block_size,
                       panel.data() + std::size_t(column) * block_size, lanes);
      for (int k = row + 1; k < triangle.blocks(); ++k)
        kernels.subtract(sum.data(), triangle.block(k, row), triangle.block(k, column), lanes);
      std::ranges::transform(sum, triangle.block(row, column), std::negate{});
    }
  }
}

void transpose_blocks(PackedTriangle& triangle) {
  for (int row = 0; row < triangle.blocks(); ++row)
    for (int column = 0; column <= row; ++column) {
      double* block = triangle.block(row, column);
      for (int i = 0; i < lanes; ++i)
        for (int j = 0; j < i; ++j) std::swap(block[i * lanes + j], block[j * lanes + i]);
    }
}

}  // namespace lfdcore::detail
