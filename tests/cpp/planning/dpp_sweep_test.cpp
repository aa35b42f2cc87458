#include "../../../cpp/src/planning/dpp_sweep.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace lfdcore {
namespace {

TEST(DppSweep, gives_the_same_on_every_instruction_set_of_this_cpu) {
  constexpr int height = 11, stride = 24;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> spread(-3000, 3000);
  std::bernoulli_distribution blocked(0.3);
  std::vector<double> y(height * stride), reward(y.size()), self(stride, 1), rows(detail::row_workspace(stride));
  for (std::size_t i = 0; i < y.size(); ++i) {
    y[i] = reward[i] = blocked(random) ? detail::blocked_value : spread(random);
  }
  const detail::SweepGrid grid{height, stride, reward.data(), self.data(), self.data(), rows.data()};
  std::vector<double> wanted(y.size()), found(y.size());
  const auto sweeps = detail::sweeps_of_this_cpu();
  sweeps[0](grid, y.data(), 0.99, 7, wanted.data());
  for (detail::Sweep* sweep : sweeps) {
    sweep(grid, y.data(), 0.99, 7, found.data());
    for (std::size_t i = 0; i < y.size(); ++i) {
      if (reward[i] < detail::blocked_below) continue;
      EXPECT_NEAR(found[i], wanted[i], 1e-9) << i;
    }
  }
}

}  // namespace
}  // namespace lfdcore
