#include "lfdcore/primitives/sequence.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "../allocation_count.hpp"

namespace lfdcore {
namespace {

// Two tasks along a line, forwards and backwards, of 60 samples.
SequenceHmm lines() {
  const auto line = [](double slope, double offset) {
    RowMatrix path(60, 2);
    for (int t = 0; t < 60; ++t) path.row(t) << slope * t / 59 + offset, offset - 0.5 * t / 59;
    return path;
  };
  return SequenceHmm::fit({{line(1, 0.01), line(1, -0.01)}, {line(-1, 0.01), line(-1, -0.01)}});
}

TEST(SequenceHmm, knows_the_task_and_its_progress) {
  SequenceHmm hmm = lines();
  for (int t = 0; t < 30; ++t) hmm.observe(std::array{-t / 59.0, -0.5 * t / 59});
  EXPECT_EQ(hmm.belief().recognised, 1);
  EXPECT_NEAR(hmm.belief().progress[1], 0.5, 0.05);
  EXPECT_NEAR(hmm.belief().probabilities.sum() + hmm.belief().none, 1, 1e-12);
}

TEST(SequenceHmm, lets_time_pass_where_nothing_was_seen) {
  constexpr double unseen = std::numeric_limits<double>::quiet_NaN();
  SequenceHmm hmm = lines();
  for (int t = 0; t < 30; ++t) hmm.observe(std::array{t / 59.0, -0.5 * t / 59});
  const double before = hmm.belief().progress[0], likelihood = hmm.belief().log_likelihood;
  for (int t = 0; t < 10; ++t) hmm.observe(std::array{unseen, unseen});
  EXPECT_NEAR(hmm.belief().progress[0], before + 10 / 59.0, 0.02);
  EXPECT_NEAR(hmm.belief().log_likelihood, likelihood, 1e-9);
}

TEST(SequenceHmm, does_not_allocate) {
  if (!test::counts_allocations) GTEST_SKIP() << "nothing counts allocations in this build";
  SequenceHmm hmm = lines();
  const long before = test::allocation_count();
  for (int t = 0; t < 60; ++t) hmm.observe(std::array{t / 59.0, -0.5 * t / 59});
  EXPECT_EQ(test::allocation_count(), before);
}

}  // namespace
}  // namespace lfdcore
