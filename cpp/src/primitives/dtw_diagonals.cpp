#include "dtw_diagonals.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#define LFDCORE_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))

namespace lfdcore::detail {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();

LFDCORE_CLONES void absolute_difference(const double* __restrict a, const double* __restrict b, int count,
                                        double* __restrict out) {
  for (int r = 0; r < count; ++r) out[r] = std::abs(a[r] - b[r]);
}

LFDCORE_CLONES void add_square(const double* __restrict a, const double* __restrict b, int count,
                               double* __restrict out) {
  for (int r = 0; r < count; ++r) out[r] += (a[r] - b[r]) * (a[r] - b[r]);
}

// Two dimensions at once: half the traffic with the sums.
LFDCORE_CLONES void add_squares(const double* __restrict a, const double* __restrict b, const double* __restrict a2,
                                const double* __restrict b2, int count, double* __restrict out) {
  for (int r = 0; r < count; ++r) {
    const double first = (a[r] - b[r]) * (a[r] - b[r]);
    out[r] = out[r] + first + (a2[r] - b2[r]) * (a2[r] - b2[r]);
  }
}

LFDCORE_CLONES void square_roots(double* __restrict values, int count) {
  for (int r = 0; r < count; ++r) values[r] = std::sqrt(values[r]);
}

// last[r] is the cell left of r, last[r - 1] the one above, before[r - 1] the one above left.
LFDCORE_CLONES void accumulate(const double* __restrict cost, const double* __restrict last,
                               const double* __restrict before, int count, double* __restrict current) {
  for (int r = 0; r < count; ++r) {
    const double straight = last[r] < last[r - 1] ? last[r] : last[r - 1];
    current[r] = cost[r] + (straight < before[r - 1] ? straight : before[r - 1]);
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
  costs_.resize(strip_height);
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
      const double* a = a_.data() + strip.first_row + lo;
      const double* b = b_.data() + (columns_ - 1 - k + lo);
      if (dimensions_ == 1) {
        absolute_difference(a, b, count, costs_.data());
      } else {
        std::fill_n(costs_.begin(), count, 0.0);
        int d = 0;
        for (; d + 1 < dimensions_; d += 2)
          add_squares(a + d * std::ptrdiff_t{rows_}, b + d * std::ptrdiff_t{columns_},
                      a + (d + 1) * std::ptrdiff_t{rows_}, b + (d + 1) * std::ptrdiff_t{columns_}, count,
                      costs_.data());
        if (d < dimensions_)
          add_square(a + d * std::ptrdiff_t{rows_}, b + d * std::ptrdiff_t{columns_}, count, costs_.data());
        square_roots(costs_.data(), count);
      }
      accumulate(costs_.data(), last_.data() + lo + 1, before_last_.data() + lo + 1, count, current_.data() + lo + 1);
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
