#include "lfdcore/grid/distance_field.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace lfdcore {
namespace {

TEST(DistanceField, equals_the_least_distance_over_every_pair_of_cells) {
  std::mt19937 random(5);
  for (const double density : {0.0, 0.01, 0.2}) {
    std::bernoulli_distribution occupied(density);
    Mask mask(17, 29);
    for (auto& value : mask.reshaped()) value = occupied(random);
    const FloatGrid field = distance_field(mask, 0.05);
    for (int iy = 0; iy < 17; ++iy) {
      for (int ix = 0; ix < 29; ++ix) {
        double nearest = std::numeric_limits<double>::infinity();
        for (int y = 0; y < 17; ++y)
          for (int x = 0; x < 29; ++x)
            if (mask(y, x)) nearest = std::min(nearest, 0.05 * std::hypot(x - ix, y - iy));
        if (std::isinf(nearest)) {
          ASSERT_TRUE(std::isinf(field(iy, ix)));
        } else {
          ASSERT_NEAR(field(iy, ix), nearest, 1e-6);
        }
      }
    }
  }
}

}  // namespace
}  // namespace lfdcore
