#include "dtw_diagonals.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "../vectorised.hpp"

namespace lfdcore::detail {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();

// Cells of an anti-diagonal; between the dimensions of a and of b lie `rows` and `columns` values.
struct Diagonal {
  int count;
  std::ptrdiff_t rows, columns;
};

// last[r] is the cell left of r, last[r - 1] the one above, before[r - 1] the one above left.
LFDCORE_INLINE double least_before(const double* last, const double* before, int r) {
  const double straight = last[r] < last[r - 1] ? last[r] : last[r - 1];
  return straight < before[r - 1] ? straight : before[r - 1];
}

template <int D>
LFDCORE_INLINE void take_few(const Diagonal& at, const double* __restrict a, const double* __restrict b,
                             const double* __restrict last, const double* __restrict before,
                             double* __restrict current) {
  for (int r = 0; r < at.count; ++r) {
    double squared = 0;
    for (int d = 0; d < D; ++d) {
      const double difference = a[d * at.rows + r] - b[d * at.columns + r];
      squared += difference * difference;
    }
    current[r] = std::sqrt(squared) + least_before(last, before, r);
  }
}

LFDCORE_INLINE void take_one(const Diagonal& at, const double* __restrict a, const double* __restrict b,
                             const double* __restrict last, const double* __restrict before,
                             double* __restrict current) {
  for (int r = 0; r < at.count; ++r) current[r] = std::abs(a[r] - b[r]) + least_before(last, before, r);
}

LFDCORE_INLINE void take_many(const Diagonal& at, int dimensions, const double* __restrict a,
                              const double* __restrict b, const double* __restrict last,
                              const double* __restrict before, double* __restrict current) {
  for (int r = 0; r < at.count; ++r) current[r] = 0;
  for (int d = 0; d < dimensions; ++d, a += at.rows, b += at.columns)
    for (int r = 0; r < at.count; ++r) current[r] += (a[r] - b[r]) * (a[r] - b[r]);
  for (int r = 0; r < at.count; ++r) current[r] = std::sqrt(current[r]) + least_before(last, before, r);
}

LFDCORE_CLONES void take(const Diagonal& at, int dimensions, const double* a, const double* b, const double* last,
                         const double* before, double* current) {
  switch (dimensions) {
    case 1:
      return take_one(at, a, b, last, before, current);
    case 2:
      return take_few<2>(at, a, b, last, before, current);
    case 3:
      return take_few<3>(at, a, b, last, before, current);
    case 4:
      return take_few<4>(at, a, b, last, before, current);
    case 6:
      return take_few<6>(at, a, b, last, before, current);
    case 7:
      return take_few<7>(at, a, b, last, before, current);
    default:
      return take_many(at, dimensions, a, b, last, before, current);
  }
}

int half_up(int x) { return x >= 0 ? (x + 1) / 2 : -(-x / 2); }
int half_down(int x) { return -half_up(-x); }

}  // namespace

DtwDiagonals::DtwDiagonals(const RowMatrix& a, const RowMatrix& b, int window)
    : rows_(static_cast<int>(a.rows())),
      columns_(static_cast<int>(b.rows())),
      dimensions_(static_cast<int>(a.cols())),
      window_(window),
      a_(a.size()),
      b_(b.size()) {
  Eigen::Map<RowMatrix>(a_.data(), a.cols(), a.rows()) = a.transpose();
  Eigen::Map<RowMatrix>(b_.data(), b.cols(), b.rows()) = b.colwise().reverse().transpose();
  for (auto* diagonal : {&current_, &last_, &before_last_}) diagonal->resize(strip_height + 3);
  nothing_above_.assign(static_cast<std::size_t>(columns_), inf);
}

// In a diagonal, element r + 1 is row r of the strip; element 0 is the row above. Beside the cells of [lo, hi] stands
// inf; the bounds move by at most one from a diagonal to the next, so no neighbour that is read was left stale.
void DtwDiagonals::sweep(const Strip& strip) {
  std::fill(last_.begin(), last_.end(), inf);
  std::fill(before_last_.begin(), before_last_.end(), inf);
  const int end = std::min(strip.height - 1 + columns_, 2 * strip.height - 1 + strip.first_row + window_);
  const int begin = std::max(0, strip.first_row - window_);
  last_[0] = strip.above[begin];
  before_last_[0] = begin > 0 ? strip.above[begin - 1] : strip.first_row == 0 ? 0 : inf;
  for (int k = begin; k < end; ++k) {
    const int lo = std::max({0, k - columns_ + 1, half_up(k - strip.first_row - window_)});
    const int hi = std::max(-1, std::min({strip.height - 1, k, half_down(k - strip.first_row + window_)}));
    const int count = hi - lo + 1;
    current_[static_cast<std::size_t>(hi) + 2] = inf;
    current_[static_cast<std::size_t>(lo)] = lo == 0 && k + 1 < columns_ ? strip.above[k + 1] : inf;
    if (count > 0) {
      const std::size_t first = static_cast<std::size_t>(lo) + 1;
      take({count, rows_, columns_}, dimensions_, &a_[static_cast<std::size_t>(strip.first_row + lo)],
           &b_[static_cast<std::size_t>(columns_ - 1 - k + lo)], &last_[first], &before_last_[first], &current_[first]);
      for (int r = std::max(lo, strip.first_kept); r <= hi; ++r)
        strip.rows[r * strip.pitch + k - r] = current_[static_cast<std::size_t>(r) + 1];
    }
    before_last_.swap(last_);
    last_.swap(current_);
  }
}

void DtwDiagonals::fill(double* costs) {
  for (int i = 0; i < rows_; i += strip_height) {
    double* first = costs + i * std::ptrdiff_t{columns_};
    sweep({i, std::min(strip_height, rows_ - i), i > 0 ? first - columns_ : nothing_above_.data(), first, columns_, 0});
  }
}

double DtwDiagonals::distance() {
  // A strip's last row takes the place of the row above it, whose cells have been read by then.
  std::vector<double> row(nothing_above_);
  for (int i = 0; i < rows_; i += strip_height) {
    const int height = std::min(strip_height, rows_ - i);
    sweep({i, height, row.data(), row.data(), 0, height - 1});
  }
  return row.back();
}

LFDCORE_CLONES void distances_to(const double* __restrict reference, int count, int dimensions,
                                 const double* __restrict sample, const unsigned char* __restrict use,
                                 double* __restrict out) {
  for (int j = 0; j < count; ++j) out[j] = 0;
  for (int d = 0; d < dimensions; ++d) {
    if (!use[d]) continue;
    const double* column = reference + d * std::ptrdiff_t{count};
    for (int j = 0; j < count; ++j) out[j] += (sample[d] - column[j]) * (sample[d] - column[j]);
  }
  for (int j = 0; j < count; ++j) out[j] = std::sqrt(out[j]);
}

}  // namespace lfdcore::detail
