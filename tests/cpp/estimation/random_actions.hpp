// Actions on the way to goals, to test what is learned of them.
#pragma once

#include <initializer_list>
#include <random>
#include <vector>

#include "lfdcore/estimation/action_model.hpp"

namespace lfdcore::test {

struct ActionData {
  RowMatrix states, goals, actions;
  std::vector<ActionKernel> kernels;
};

inline Eigen::VectorXd values(std::initializer_list<double> list) {
  return Eigen::Map<const Eigen::VectorXd>(list.begin(), static_cast<Eigen::Index>(list.size()));
}

// `jitter` moves each sample's goal by so much: 0 leaves four goals.
inline ActionData random_actions(int count, double jitter = 0) {
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto draw = [&] { return uniform(generator); };
  const RowMatrix places = RowMatrix::NullaryExpr(4, 2, draw) * 3;
  ActionData data{RowMatrix::NullaryExpr(count, 3, draw), RowMatrix(count, 2), RowMatrix(count, 2), {}};
  for (int n = 0; n < count; ++n)
    data.goals.row(n) = places.row((n * 7) % 4) + jitter * RowMatrix::NullaryExpr(1, 2, draw);
  data.actions.col(0) = (data.states.col(0) + data.goals.col(0)).array().sin() + 0.1 * draw();
  data.actions.col(1) = (data.states.col(1).cwiseProduct(data.goals.col(1))).array().cos() + 0.1 * draw();
  data.kernels = {{1.2, values({0.7, 0.8, 0.9}), values({1.5, 2}), 0.2},
                  {0.8, values({0.5, 1, 0.9}), values({2, 1.1}), 0.3}};
  return data;
}

/// Where a driver may be heading to, and a state on the way there.
inline Belief uncertain_goal() {
  Belief made{GoalVector(2), GoalMatrix(2, 2)};
  made.mean << 0.3, -0.4;
  made.covariance << 1, 0.3, 0.3, 0.5;
  return made;
}

inline const std::vector<double> state_on_the_way = {0.1, 0.2, -0.3};

}  // namespace lfdcore::test
