// The vectorised inner loops of Gaussian processes on 32 x 32 blocks: see gaussian_blocks.cpp.
#pragma once

#include <vector>

#include "lfdcore/estimation/kernel.hpp"

namespace lfdcore::detail {

// Rows (and columns) of a block. A block holds values[column * lanes + row]; a panel is blocks side by side, so that
// "one column of 32 rows" is contiguous in both.
constexpr int lanes = 32;
constexpr int block_size = lanes * lanes;

struct BlockKernels {
  // values[j][i] = a^2 k(r_ij) for i < lanes, j < count, from inputs divided by the length-scales, (dims, lanes) each.
  // If slopes is not null, slopes[j][i] u_d^2 is the derivative by log l_d, u_d = (x_d - x'_d) / l_d.
  void (*covariance)(KernelFamily family, double variance, const double* rows, const double* columns, int dims,
                     int count, double* values, double* slopes);
  // block[j][i] -= sum_k columns[k][j] rows[k][i], k < depth
  void (*subtract)(double* block, const double* rows, const double* columns, int depth);
  // B <- B L^-T for the diagonal block L
  void (*solve)(double* block, const double* lower);
  // The Cholesky factor of a diagonal block in place, zeros above it. -> lanes, or the first row whose pivot is not
  // above smallest[row] (or not finite).
  int (*factor)(double* block, const double* smallest);
  // sums[i] += sum_k panel[k][i] values[k], k < depth
  void (*accumulate)(double* sums, const double* panel, const double* values, int depth);
};

// While it lives, this thread's subnormal numbers are 0: short length-scales fill a factor with them, and arithmetic on
// them is several times slower. On other processors than x86-64 nothing is changed.
class SubnormalsFlushed {
 public:
  SubnormalsFlushed();
  ~SubnormalsFlushed();
  SubnormalsFlushed(const SubnormalsFlushed&) = delete;
  SubnormalsFlushed& operator=(const SubnormalsFlushed&) = delete;

 private:
  [[maybe_unused]] unsigned before_;
};

// Every version that this CPU runs, the fastest last.
std::vector<BlockKernels> block_kernels_of_this_cpu();

}  // namespace lfdcore::detail
