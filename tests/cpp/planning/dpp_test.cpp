#include "lfdcore/planning/dpp.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "../../../cpp/src/planning/dpp_sweep.hpp"
#include "../allocation_count.hpp"

namespace lfdcore {
namespace {

GridMdp random_mdp(int height, int width, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> reward(-100, 100);
  std::bernoulli_distribution blocked(0.3);
  return {FloatGrid::NullaryExpr(height, width, [&] { return reward(random); }),
          Mask::NullaryExpr(height, width, [&] { return blocked(random); })};
}

double boltzmann_mean(const GridMdp& mdp, const Preferences& psi, Cell cell, double eta) {
  const int row = cell.iy * mdp.width() + cell.ix;
  double highest = -1e300, sum = 0, weighted = 0;
  for (int a = 0; a < action_count; ++a) {
    if (mdp.available(cell, a)) highest = std::max(highest, psi(row, a));
  }
  for (int a = 0; a < action_count; ++a) {
    if (!mdp.available(cell, a)) continue;
    const double weight = std::exp(eta * (psi(row, a) - highest));
    sum += weight;
    weighted += weight * psi(row, a);
  }
  return sum > 0 ? weighted / sum : 0;
}

// D.7 as printed.
Preferences slow_dpp(const GridMdp& mdp, const DppConfig& config) {
  const int width = mdp.width(), cells = static_cast<int>(mdp.reward.size());
  Preferences psi = Preferences::Zero(cells, action_count);
  Eigen::ArrayXd mean(cells);
  for (int k = 0; k < config.sweeps; ++k) {
    for (int i = 0; i < cells; ++i) {
      mean(i) = boltzmann_mean(mdp, psi, {i % width, i / width}, config.inverse_temperature);
    }
    for (int i = 0; i < cells; ++i) {
      for (int a = 0; a < action_count; ++a) {
        const Cell next = mdp.successor({i % width, i / width}, a);
        psi(i, a) += mdp.reward(next.iy, next.ix) + config.discount * mean(next.iy * width + next.ix) - mean(i);
      }
    }
  }
  return psi;
}

TEST(DppSolver, equals_the_printed_recursion) {
  for (const auto& [height, width] : {std::pair{1, 1}, {1, 9}, {7, 1}, {13, 21}}) {
    const GridMdp mdp = random_mdp(height, width, 1);
    const DppConfig config{.sweeps = 150};
    DppResult result;
    DppSolver(config).solve(mdp, result);
    const Preferences slow = slow_dpp(mdp, config), fast = result.preferences();
    const double scale = slow.abs().maxCoeff();
    for (int i = 0; i < slow.rows(); ++i) {
      for (int a = 0; a < action_count; ++a) {
        if (!mdp.available({i % width, i / width}, a)) continue;
        EXPECT_NEAR(fast(i, a), slow(i, a), 1e-10 * scale);
      }
    }
  }
}

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

TEST(DppSolver, does_not_allocate_on_the_second_grid_of_a_size) {
  const GridMdp first = random_mdp(60, 50, 2), second = random_mdp(60, 50, 2);
  DppSolver solver({.sweeps = 5});
  DppResult result;
  const long at_start = test::allocation_count();
  solver.solve(first, result);
  const long before = test::allocation_count();
  solver.solve(second, result);
  EXPECT_EQ(test::allocation_count(), before);
  if (test::counts_allocations) EXPECT_GT(before, at_start);
}

TEST(GridMdp, moves_out_of_the_grid_stay) {
  const GridMdp mdp(FloatGrid::Zero(2, 3));
  EXPECT_EQ(mdp.successor({2, 0}, 8), (Cell{2, 0}));
  EXPECT_EQ(mdp.successor({1, 0}, 6), (Cell{0, 1}));
  EXPECT_EQ(mdp.successor({1, 1}, stay_action), (Cell{1, 1}));
}

TEST(GridMdp, cuts_a_corner_but_does_not_pass_between_two_blocked_cells) {
  GridMdp mdp(FloatGrid::Zero(2, 2));
  mdp.blocked(0, 1) = true;
  EXPECT_TRUE(mdp.available({0, 0}, 8));
  mdp.blocked(1, 0) = true;
  EXPECT_FALSE(mdp.available({0, 0}, 8));
  EXPECT_FALSE(mdp.available({0, 0}, 5));
  EXPECT_TRUE(mdp.available({0, 0}, stay_action));
  EXPECT_FALSE(mdp.available({1, 0}, stay_action));
}

}  // namespace
}  // namespace lfdcore
