#include "basis_kernel.hpp"

#include "../vectorised.hpp"

LFDCORE_VECTOR_MATH(double exp(double));

namespace lfdcore::detail {
namespace {

constexpr std::size_t lanes = 8;
constexpr double negligible = 100;  // e^-100 beside the largest, 1; below e^-708 libmvec takes the slow way

}  // namespace

// The exponentials have a loop of their own without inner lanes: only so does the compiler call the
// vector function, and with no choice in it, since it would take that after the call.
LFDCORE_CLONES void basis_row(double x, const double* centres, const double* widths, std::size_t count, double* row) {
  count -= count % lanes;
  double least[lanes], sums[lanes] = {};
  for (std::size_t l = 0; l < lanes; ++l) least[l] = widths[l] * (x - centres[l]) * (x - centres[l]);
  for (std::size_t i = 0; i < count; i += lanes)
    for (std::size_t l = 0; l < lanes; ++l) {
      const double away = x - centres[i + l];
      row[i + l] = widths[i + l] * away * away;
      least[l] = row[i + l] < least[l] ? row[i + l] : least[l];
    }
  double nearest = least[0];
  for (std::size_t l = 1; l < lanes; ++l) nearest = least[l] < nearest ? least[l] : nearest;
  for (std::size_t i = 0; i < count; ++i) {
    const double beyond = row[i] - nearest;
    row[i] = beyond < negligible ? -beyond : -negligible;
  }
  for (std::size_t i = 0; i < count; ++i) row[i] = exp(row[i]);
  for (std::size_t i = 0; i < count; i += lanes)
    for (std::size_t l = 0; l < lanes; ++l) sums[l] += row[i + l];
  double sum = 0;
  for (const double lane : sums) sum += lane;
  const double scale = x / sum;
  for (std::size_t i = 0; i < count; ++i) row[i] *= scale;
}

}  // namespace lfdcore::detail
