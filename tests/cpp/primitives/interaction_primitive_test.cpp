#include "lfdcore/primitives/interaction_primitive.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <vector>

namespace lfdcore {
namespace {

constexpr double unseen = std::numeric_limits<double>::quiet_NaN();

struct Demonstrations {
  std::vector<RowMatrix> partner, robot;
  RowMatrix environment;
};

// The partner and, twice as far, the robot rise over a height that is the environment.
Demonstrations demonstrations(int count, int partner_dimensions) {
  Demonstrations made{{}, {}, RowMatrix(count, 1)};
  for (int j = 0; j < count; ++j) {
    const int steps = 41 + 3 * j;
    const double height = 1 + 0.1 * j;
    RowMatrix partner(steps, partner_dimensions), robot(steps, 2);
    for (int k = 0; k < steps; ++k) {
      const double rise = height * std::pow(std::sin(1.5 * k / (steps - 1)), 2);
      for (int d = 0; d < partner_dimensions; ++d) partner(k, d) = rise + 0.01 * d * j;
      robot.row(k) << 2 * rise, -rise;
    }
    made.partner.push_back(partner);
    made.robot.push_back(robot);
    made.environment(j, 0) = height;
  }
  return made;
}

// Counts on either side of a vector's lanes: padding must not be read as data, nor data be written past it.
TEST(InteractionPrimitive, one_by_one_is_all_at_once_for_counts_around_the_lanes) {
  for (const int count : {2, 7, 8, 9}) {
    for (const int dimensions : {1, 3, 9}) {
      const Demonstrations shown = demonstrations(count, dimensions);
      InteractionPrimitiveConfig config{.observe = Observed::positions, .noise = 1e-4};
      const auto primitive = InteractionPrimitive::fit(shown.partner, shown.robot, shown.environment, config);
      const Eigen::VectorXd phase = phases(30, config.dmp).head(20), scene = Eigen::VectorXd::Constant(1, 1.04);
      RowMatrix seen = shown.partner[1].topRows(20);
      seen(3, 0) = seen(19, dimensions - 1) = unseen;
      InteractionObserver observer = primitive.begin(scene);
      for (int k = 0; k < 20; ++k) observer.observe(phase[k], seen.row(k).transpose());
      const auto one_by_one = observer.posterior(), at_once = primitive.condition(seen, phase, scene);
      EXPECT_LT((one_by_one.mean() - at_once.mean()).norm(), 1e-7 * at_once.mean().norm());
      EXPECT_NEAR(one_by_one.log_likelihood(), at_once.log_likelihood(), 1e-6 * std::abs(at_once.log_likelihood()));
    }
  }
}

TEST(InteractionPrimitive, forcing_of_fewer_than_three_samples_in_a_row_says_nothing) {
  const Demonstrations shown = demonstrations(5, 2);
  const InteractionPrimitiveConfig config{.observe = Observed::forcing};
  const auto primitive = InteractionPrimitive::fit(shown.partner, shown.robot, std::nullopt, config);
  RowMatrix seen = shown.partner[0].topRows(8);
  for (int k = 0; k < 8; k += 3) seen.row(k).setConstant(unseen);
  const auto posterior = primitive.condition(seen, phases(41).head(8), std::nullopt);
  const auto prior = primitive.condition(RowMatrix(0, 2), Eigen::VectorXd(0), std::nullopt);
  EXPECT_EQ(posterior.mean(), prior.mean());
}

TEST(InteractionPrimitive, trajectories_covariances_and_samples_have_the_stated_shapes) {
  const Demonstrations shown = demonstrations(4, 3);
  const auto primitive = InteractionPrimitive::fit(shown.partner, shown.robot, std::nullopt);
  const auto prior = primitive.condition(RowMatrix(0, 3), Eigen::VectorXd(0), std::nullopt);
  const InteractionTrajectory motion = prior.trajectory(13);
  EXPECT_EQ(motion.mean.rows(), 13);
  EXPECT_EQ(motion.mean.cols(), 5);
  EXPECT_EQ(motion.covariance.cols(), 25);
  EXPECT_EQ(prior.sample(6, 1).rows(), 6);
  EXPECT_EQ(prior.sample_trajectories(6, 13, 1).front().cols(), 5);
  EXPECT_EQ(prior.robot().dimensions() + prior.partner().dimensions(), 5);
}

TEST(InteractionPrimitive, without_observation_gives_the_mean_of_the_demonstrations) {
  std::mt19937 generator(4);
  std::normal_distribution<double> normal;
  const RowMatrix theta = RowMatrix::NullaryExpr(9, 42, [&] { return normal(generator); });
  InteractionPrimitiveConfig config;
  config.noise = 1.0;
  const InteractionPrimitive primitive(theta, RowMatrix::Zero(9, 2), std::nullopt, 1, config);
  const auto prior = primitive.condition(RowMatrix(0, 1), Eigen::VectorXd(), std::nullopt);
  EXPECT_LT((prior.mean() - theta.colwise().mean().transpose()).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((prior.factor() * prior.factor().transpose() -
             (theta.rowwise() - theta.colwise().mean()).transpose() * (theta.rowwise() - theta.colwise().mean()) / 9)
                .cwiseAbs()
                .maxCoeff(),
            1e-12);
}

}  // namespace
}  // namespace lfdcore
