// The vectorised inner loops of the user heatmap, apart from Eigen and <cmath>: see orientation_kernel.cpp.
#pragma once

#include <cstddef>

namespace lfdcore::detail {

/// squares[i] = (mean - orientations[i])^2, the difference wrapped to (-pi, pi]; all angles within (-pi, pi].
void wrapped_squares(const float* orientations, float mean, float* squares, std::size_t count);

/// weights[i] = exp(-(weights[i] - offset) * scale), 0 below 2e-35; filtered[i] = weights[i] * filter[i]
void weigh_squares(float* weights, float offset, float scale, const float* filter, float* filtered, std::size_t count);

}  // namespace lfdcore::detail
