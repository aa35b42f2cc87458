#include "lfdcore/primitives/phase_estimator.hpp"

#include <gtest/gtest.h>

#include <span>

#include "../allocation_count.hpp"
#include "random_walk.hpp"

namespace lfdcore {
namespace {

TEST(PhaseEstimator, does_not_allocate) {
  if (!test::counts_allocations) GTEST_SKIP() << "nothing counts allocations in this build";
  const RowMatrix reference = test::walk(300, 6, 3);
  PhaseEstimator estimator(reference, 3);
  const long before = test::allocation_count();
  for (int t = 0; t < 300; ++t) estimator.observe(0.001 * t, std::span<const double>(reference.row(t).data(), 6));
  EXPECT_EQ(test::allocation_count(), before);
  EXPECT_TRUE(estimator.phase().determined);
}

}  // namespace
}  // namespace lfdcore
