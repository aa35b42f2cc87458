// One sweep of Q-learning over a padded grid, vectorised. Private to planning/.
#pragma once

namespace lfdcore::detail {

inline constexpr int q_lanes = 8;
/// The value of blocked cells and of padding; values below q_blocked_below belong to them, also after any sweep.
inline constexpr double q_blocked_value = -1e200, q_blocked_below = -1e100;

inline int q_row_workspace(int stride) { return 3 * stride; }

/// q(s) = keep q(s) + gain(s) + pull max q over the 3 x 3 around s, from the values before, in place. Rows of `stride`
/// cells, a multiple of q_lanes, of which the last and those just before and after the grid are padding.
void q_sweep(double* q, const double* gain, double keep, double pull, int height, int stride, double* rows);

}  // namespace lfdcore::detail
