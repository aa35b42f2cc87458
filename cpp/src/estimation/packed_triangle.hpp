// Lower triangles of some thousand rows, factorised and inverted in place: at most one triangle in memory.
#pragma once

#include <vector>

#include "gaussian_blocks.hpp"

namespace lfdcore::detail {

// Blocks of 32 x 32, block row after block row; a block holds values[column * lanes + row], so that 32 rows of one
// column are contiguous, and one block row is a panel.
class PackedTriangle {
 public:
  explicit PackedTriangle(int blocks) : blocks_(blocks), values_(std::size_t(blocks) * (blocks + 1) / 2 * block_size) {}

  int blocks() const { return blocks_; }
  double* block(int row, int column) { return values_.data() + offset(row, column); }
  const double* block(int row, int column) const { return values_.data() + offset(row, column); }
  std::size_t bytes() const { return values_.size() * sizeof(double); }

 private:
  static std::size_t offset(int row, int column) {
    return (std::size_t(row) * (row + 1) / 2 + column) * static_cast<std::size_t>(block_size);
  }

  int blocks_;
  std::vector<double> values_;
};

// block -= sum over a depth that need not fit into a cache.
void subtract_deep(const BlockKernels& kernels, double* block, const double* rows, const double* columns, int depth);

// A -> L with A = L L'. -> -1, or the row whose pivot is rounding error or no number.
int factor(PackedTriangle& triangle, const BlockKernels& kernels);

// L -> L^-1, each block transposed (values[row * lanes + column]).
void invert(PackedTriangle& triangle, const BlockKernels& kernels);

// M with transposed blocks -> the lower triangle of M'M; the blocks on the diagonal are whole.
void gram(PackedTriangle& triangle, const BlockKernels& kernels);

void transpose_blocks(PackedTriangle& triangle);

}  // namespace lfdcore::detail
