#include "lfdcore/planning/dpp.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../allocation_count.hpp"
#include "random_mdp.hpp"

namespace lfdcore {
namespace {

using test::random_mdp;

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

}  // namespace
}  // namespace lfdcore
