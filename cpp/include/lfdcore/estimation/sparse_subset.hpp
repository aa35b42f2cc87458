// Alg. 1 as reconstructed in ERRATA 11: which samples a sparse action model keeps.
#pragma once

#include <cstdint>
#include <vector>

#include "lfdcore/estimation/action_model.hpp"

namespace lfdcore {

/// (size,) greedy indices in the order of selection. Each round draws `candidates` samples from those left (59:
/// one is in the best 5 % with 95 %) and takes the one that lowers sum_a Q_a / var(y_a) most (actions standardised,
/// ERRATA F2), ties to the smallest index. A sample gains nothing where the selected leave a Schur complement <= 1e-10
/// of its start value (ERRATA 13). The draws are the starts of Fisher-Yates shuffles with MMIX's generator. Needs some
/// 8 N (size + 96) bytes an action; forms neither K nor A. Throws std::invalid_argument as ActionModel does, for a size
/// that is not in [1, N] and for candidates < 1.
std::vector<std::int64_t> select_subset(const RowMatrix& states, const RowMatrix& goals, const RowMatrix& actions,
                                        const std::vector<ActionKernel>& kernels, int size, int candidates = 59,
                                        std::uint64_t seed = 1);

}  // namespace lfdcore
