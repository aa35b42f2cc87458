#include "lfdcore/estimation/differential_evolution.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace lfdcore {
namespace {

RowMatrix box(int dims, double low, double high) {
  RowMatrix bounds(dims, 2);
  bounds.col(0).setConstant(low);
  bounds.col(1).setConstant(high);
  return bounds;
}

double rosenbrock(std::span<const double> x, double) {
  return 100 * std::pow(x[1] - x[0] * x[0], 2) + std::pow(1 - x[0], 2);
}

double rastrigin(std::span<const double> x, double) {
  double sum = 0;
  for (const double v : x) sum += 10 + v * v - 10 * std::cos(2 * std::numbers::pi * v);
  return sum;
}

DifferentialEvolutionConfig exact(std::uint64_t seed) {
  DifferentialEvolutionConfig config;
  config.tolerance = 0;
  config.absolute_tolerance = 1e-10;
  config.seed = seed;
  return config;
}

TEST(DifferentialEvolution, finds_the_minimum_of_a_valley_and_among_121_local_ones) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const auto valley = differential_evolution(rosenbrock, box(2, -5, 5), exact(seed));
    EXPECT_TRUE(valley.converged);
    EXPECT_LT((valley.best - Eigen::Vector2d(1, 1)).norm(), 1e-3);
    auto many = exact(seed);
    many.population = 40;  // with 15 it, as SciPy's, ends in a local minimum one time in ten
    const auto hills = differential_evolution(rastrigin, box(2, -5.12, 5.12), many);
    EXPECT_LT(hills.best.norm(), 1e-3);
    EXPECT_NEAR(hills.value, 0, 1e-6);
  }
}

TEST(DifferentialEvolution, stays_in_its_box_even_where_the_minimum_is_outside) {
  const RowMatrix bounds = box(3, 0.5, 2);
  const auto inside = [](std::span<const double> x, double) {
    double sum = 0;
    for (const double v : x) {
      EXPECT_GE(v, 0.5);
      EXPECT_LE(v, 2);
      sum += v;
    }
    return sum;
  };
  EXPECT_NEAR(differential_evolution(inside, bounds, exact(0)).value, 1.5, 1e-3);
}

TEST(DifferentialEvolution, changes_one_parameter_a_trial_without_recombination) {
  const auto sphere = [](std::span<const double> x, double) { return x[0] * x[0] + x[1] * x[1]; };
  auto config = exact(1);
  config.recombination = 0;
  EXPECT_LT(differential_evolution(sphere, box(2, -3, 5), config).best.norm(), 1e-3);
}

TEST(DifferentialEvolution, never_tries_the_best_place_again_since_its_two_other_members_differ) {
  double best = 100, lowest = std::numeric_limits<double>::infinity();
  int again = 0;
  auto config = exact(1);
  config.recombination = 1;
  config.generations = 20;
  const auto remembering = [&](std::span<const double> x, double) {
    again += x[0] == best;
    if (x[0] * x[0] < lowest) best = x[0], lowest = x[0] * x[0];
    return x[0] * x[0];
  };
  differential_evolution(remembering, box(1, -3, 5), config);
  EXPECT_EQ(again, 0);
}

TEST(DifferentialEvolution, takes_the_same_steps_whether_hopeless_trials_are_evaluated_or_given_up) {
  const auto bounded = [](std::span<const double> x, double worth) {
    const double value = rastrigin(x, worth);
    return value > worth ? std::numeric_limits<double>::infinity() : value;
  };
  const auto full = differential_evolution(rastrigin, box(3, -5, 5), exact(2));
  const auto early = differential_evolution(bounded, box(3, -5, 5), exact(2));
  EXPECT_EQ(full.best, early.best);
  EXPECT_EQ(full.evaluations, early.evaluations);
}

TEST(DifferentialEvolution, repeats_itself_with_the_same_seed_only) {
  const auto first = differential_evolution(rosenbrock, box(2, -5, 5), exact(1));
  EXPECT_EQ(first.best, differential_evolution(rosenbrock, box(2, -5, 5), exact(1)).best);
  EXPECT_NE(first.evaluations, differential_evolution(rosenbrock, box(2, -5, 5), exact(2)).evaluations);
}

TEST(DifferentialEvolution, counts_nan_as_the_worst_and_ends_when_all_is_nan) {
  const auto holes = [](std::span<const double> x, double) { return x[0] < 0 ? NAN : x[0]; };
  EXPECT_NEAR(differential_evolution(holes, box(1, -1, 1), exact(0)).value, 0, 1e-3);
  auto config = exact(0);
  config.generations = 3;
  const auto nothing = differential_evolution([](auto, double) { return NAN; }, box(1, 0, 1), config);
  EXPECT_FALSE(nothing.converged);
  EXPECT_EQ(nothing.value, std::numeric_limits<double>::infinity());
}

TEST(DifferentialEvolution, refuses_bounds_and_settings_that_make_no_search) {
  EXPECT_THROW(differential_evolution(rosenbrock, box(2, 1, 1), {}), std::invalid_argument);
  EXPECT_THROW(differential_evolution(rosenbrock, box(2, 0, NAN), {}), std::invalid_argument);
  EXPECT_THROW(differential_evolution(rosenbrock, RowMatrix(0, 2), {}), std::invalid_argument);
  DifferentialEvolutionConfig bad;
  bad.recombination = 1.5;
  EXPECT_THROW(differential_evolution(rosenbrock, box(2, 0, 1), bad), std::invalid_argument);
}

}  // namespace
}  // namespace lfdcore
