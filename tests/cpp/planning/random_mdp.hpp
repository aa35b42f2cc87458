// A grid world to solve.
#pragma once

#include <random>

#include "lfdcore/planning/grid_mdp.hpp"

namespace lfdcore::test {

/// Rewards in [-100, 100], three cells in ten blocked.
inline GridMdp random_mdp(int height, int width, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> reward(-100, 100);
  std::bernoulli_distribution blocked(0.3);
  return {FloatGrid::NullaryExpr(height, width, [&] { return reward(random); }),
          Mask::NullaryExpr(height, width, [&] { return blocked(random); })};
}

}  // namespace lfdcore::test
