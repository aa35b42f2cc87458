#include "lfdcore/primitives/open_end_dtw.hpp"

#include <gtest/gtest.h>

#include <span>

#include "../allocation_count.hpp"
#include "lfdcore/primitives/dtw.hpp"
#include "random_walk.hpp"

namespace lfdcore {
namespace {

using test::walk;

TEST(OpenEndDtw, is_the_argmin_of_the_last_row) {
  const RowMatrix query = walk(70, 3, 1), reference = walk(90, 3, 2), costs = dtw(query, reference).costs;
  Eigen::Index best = 0;
  const double distance = costs.bottomRows<1>().minCoeff(&best);
  const OpenEndPhase phase = open_end_dtw(query, reference);
  EXPECT_EQ(phase.index, best);
  EXPECT_EQ(phase.distance, distance);
}

TEST(OpenEndDtw, does_not_allocate) {
  if (!test::counts_allocations) GTEST_SKIP() << "nothing counts allocations in this build";
  const RowMatrix reference = walk(300, 6, 3);
  OpenEndDtw dtw(reference);
  const long before = test::allocation_count();
  for (int t = 0; t < 300; ++t) dtw.observe(std::span<const double>(reference.row(t).data(), 6));
  EXPECT_EQ(test::allocation_count(), before);
  EXPECT_EQ(dtw.phase().index, 299);
}

}  // namespace
}  // namespace lfdcore
