#include "orientation_kernel.hpp"

#include "../vectorised.hpp"

LFDCORE_VECTOR_MATH(float expf(float));

namespace lfdcore::detail {

// Its exponential, 2e-35, is nothing beside the peak of 1. Below, libmvec takes the scalar way, and subnormal numbers
// are slow.
constexpr float lowest_exponent = -80;

LFDCORE_CLONES void wrapped_squares(const float* orientations, float mean, float* squares, std::size_t count) {
  constexpr float full_turn = 6.283185307179586f;
  for (std::size_t i = 0; i < count; ++i) {
    const float difference = mean - orientations[i];
    const float apart = difference < 0 ? -difference : difference;
    const float other_way = full_turn - apart;
    const float shorter = apart < other_way ? apart : other_way;
    squares[i] = shorter * shorter;
  }
}

// Two loops: in one, the compiler would move the bound behind expf.
LFDCORE_CLONES void weigh_squares(float* __restrict weights, float offset, float scale, const float* __restrict filter,
                                  float* __restrict filtered, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const float exponent = (offset - weights[i]) * scale;
    weights[i] = exponent > lowest_exponent ? exponent : lowest_exponent;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const float weight = expf(weights[i]);
    weights[i] = weights[i] > lowest_exponent ? weight : 0;
    filtered[i] = weights[i] * filter[i];
  }
}

}  // namespace lfdcore::detail
