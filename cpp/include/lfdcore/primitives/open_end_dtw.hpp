// Dynamic time warping whose end in the reference is open, sample by sample (Sec. 5.3.1, ERRATA 49).
#pragma once

#include <span>
#include <vector>

#include "lfdcore/row_matrix.hpp"

namespace lfdcore {

/// Where in the reference a partial series has come to.
struct OpenEndPhase {
  int index = -1;       ///< t* - 1: row of the reference, argmin_j D(m, j), ties to the smallest; -1 before any sample
  double distance = 0;  ///< D(m, t*), in the series' unit
};

/// Holds the last row of D: one caller at a time.
class OpenEndDtw {
 public:
  /// reference (n, D). Throws std::invalid_argument if it is empty or not finite and within 1e100.
  explicit OpenEndDtw(const RowMatrix& reference);

  /// The next sample (D,) in O(n D); no allocation. NaN in a dimension: not seen; the distance over the others is
  /// scaled by sqrt(D / seen), so that such a sample weighs as any. A sample without any seen dimension changes
  /// nothing. Throws std::invalid_argument, and stays as it was, for another D and for what is infinite or beyond
  /// 1e100.
  OpenEndPhase observe(std::span<const double> sample);
  void reset();  ///< forgets all samples

  OpenEndPhase phase() const { return phase_; }
  int size() const { return count_; }             ///< n
  int dimensions() const { return dimensions_; }  ///< D

 private:
  int count_, dimensions_;
  std::vector<double> reference_;  // dimension after dimension
  std::vector<double> row_, distances_;
  std::vector<unsigned char> seen_;
  OpenEndPhase phase_;
};

/// The phase after all samples of query (m, D), in O(n) memory; errors as above.
OpenEndPhase open_end_dtw(const RowMatrix& query, const RowMatrix& reference);

}  // namespace lfdcore
