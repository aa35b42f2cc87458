// The recursion of DTW along anti-diagonals, vectorised. Private to primitives/.
#pragma once

#include <cstddef>
#include <vector>

#include "lfdcore/row_matrix.hpp"

namespace lfdcore::detail {

/// The accumulated costs of DTW, computed in strips of `strip_height` rows. Within a strip the cells (i0 + r, k - r) of
/// an anti-diagonal k do not depend on each other.
class DtwDiagonals {
 public:
  static constexpr int strip_height = 64;

  /// a (m, D), b (n, D) validated; |i - j| <= window.
  DtwDiagonals(const RowMatrix& a, const RowMatrix& b, int window);

  /// Writes all of D, row-major (m, n); cells outside the window are left as they are, and must hold inf.
  void fill(double* costs);
  /// D(m, n) with two rows of memory.
  double distance();

 private:
  // Rows first_row .. first_row + height - 1. `above` is the row of D before them, or a row of inf. Row r goes to
  // rows + r * pitch for r >= first_kept.
  struct Strip {
    int first_row, height;
    const double* above;
    double* rows;
    std::ptrdiff_t pitch;
    int first_kept;
  };
  void sweep(const Strip& strip);

  int rows_, columns_, dimensions_, window_;
  std::vector<double> a_, b_;  // dimension after dimension; b backwards, so that both run forward along a diagonal
  std::vector<double> current_, last_, before_last_, nothing_above_;
};

/// out[j] = |sample - column j of reference|, where reference holds `dimensions` rows of `count`, over the dimensions
/// for which use[d] is not 0.
void distances_to(const double* reference, int count, int dimensions, const double* sample, const unsigned char* use,
                  double* out);

}  // namespace lfdcore::detail
