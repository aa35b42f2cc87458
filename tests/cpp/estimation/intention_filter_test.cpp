#include "lfdcore/estimation/intention_filter.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "../allocation_count.hpp"
#include "random_actions.hpp"

namespace lfdcore {
namespace {

using test::ActionData;
using test::random_actions;
using test::state_on_the_way;
using test::uncertain_goal;

TEST(IntentionFilter, does_not_allocate) {
  if (!test::counts_allocations) GTEST_SKIP() << "malloc is the sanitizer's";
  for (const double jitter : {0.0, 0.3}) {
    const ActionData data = random_actions(100, jitter);
    IntentionFilter filter(ActionModel(data.states, data.goals, data.actions, data.kernels), uncertain_goal(), 0.01);
    const std::vector<double> action = {0.3, 0.2};
    filter.update(state_on_the_way, action);
    const long before = test::allocation_count();
    filter.update(state_on_the_way, action);
    filter.reset();
    filter.update(state_on_the_way, action);
    EXPECT_EQ(test::allocation_count(), before) << jitter;
  }
}

}  // namespace
}  // namespace lfdcore
