#include "lfdcore/planning/q_learning.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "../allocation_count.hpp"
#include "random_mdp.hpp"

namespace lfdcore {
namespace {

using test::random_mdp;

double best_value(const GridMdp& mdp, const ActionValues& q, Cell cell) {
  double highest = -1e300;
  for (int a = 0; a < action_count; ++a) {
    if (mdp.available(cell, a)) highest = std::max(highest, q(cell.iy * mdp.width() + cell.ix, a));
  }
  return highest;
}

// D.1 as printed, over states and moves.
ActionValues slow_q_learning(const GridMdp& mdp, const QLearningConfig& config) {
  const int width = mdp.width(), cells = static_cast<int>(mdp.reward.size());
  ActionValues q = ActionValues::Constant(cells, action_count, config.initial_value);
  for (int k = 0; k < config.sweeps; ++k) {
    const ActionValues old = q;
    for (int i = 0; i < cells; ++i) {
      for (int a = 0; a < action_count; ++a) {
        if (!mdp.available({i % width, i / width}, a)) continue;
        const Cell next = mdp.successor({i % width, i / width}, a);
        const double target = mdp.reward(next.iy, next.ix) + config.discount * best_value(mdp, old, next);
        q(i, a) = old(i, a) + config.learning_rate * (target - old(i, a));
      }
    }
  }
  return q;
}

TEST(QLearningSolver, equals_the_printed_recursion) {
  for (const auto& [height, width] : {std::pair{1, 1}, {1, 9}, {7, 1}, {13, 21}, {5, 16}}) {
    for (const double learning_rate : {0.7, 1.0}) {
      const GridMdp mdp = random_mdp(height, width, 1);
      const QLearningConfig config{.learning_rate = learning_rate};
      QLearningResult result;
      QLearningSolver(config).solve(mdp, result);
      const ActionValues slow = slow_q_learning(mdp, config), fast = result.action_values();
      for (int i = 0; i < slow.rows(); ++i) {
        for (int a = 0; a < action_count; ++a) {
          if (mdp.available({i % width, i / width}, a)) {
            EXPECT_NEAR(fast(i, a), slow(i, a), 1e-9);
          } else {
            EXPECT_EQ(fast(i, a), -std::numeric_limits<double>::infinity());
          }
        }
      }
    }
  }
}

TEST(QLearningSolver, does_not_allocate_on_the_second_grid_of_a_size) {
  const GridMdp first = random_mdp(60, 50, 2), second = random_mdp(60, 50, 2);
  QLearningSolver solver({.sweeps = 5});
  QLearningResult result;
  const long at_start = test::allocation_count();
  solver.solve(first, result);
  const long before = test::allocation_count();
  solver.solve(second, result);
  EXPECT_EQ(test::allocation_count(), before);
  if (test::counts_allocations) EXPECT_GT(before, at_start);
}

TEST(QLearningSolver, solves_a_smaller_grid_after_a_larger_one) {
  QLearningSolver reused;
  QLearningResult found, wanted;
  reused.solve(random_mdp(40, 30, 3), found);
  const GridMdp small = random_mdp(9, 8, 4);
  reused.solve(small, found);
  QLearningSolver().solve(small, wanted);
  const auto same = found.successor_value == wanted.successor_value;
  EXPECT_TRUE((same || small.blocked).all());
}

TEST(GreedyPath, without_a_goal_ends_where_it_is_best_to_stay) {
  FloatGrid reward = FloatGrid::Zero(5, 9);
  reward(2, 7) = 1;
  QLearningResult result;
  QLearningSolver().solve(GridMdp(reward), result);
  const GreedyPath path = greedy_path(result, {1, 2});
  EXPECT_EQ(path.outcome, PathOutcome::stay);
  EXPECT_EQ(path.cells.row(path.cells.rows() - 1), Eigen::RowVector2i(7, 2));
  EXPECT_EQ(greedy_path(result, {1, 2}, Cell{7, 2}).outcome, PathOutcome::goal);
}

}  // namespace
}  // namespace lfdcore
