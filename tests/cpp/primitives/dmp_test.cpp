#include "lfdcore/primitives/dmp.hpp"

#include <gtest/gtest.h>

#include <random>
#include <stdexcept>

#include "../allocation_count.hpp"

namespace lfdcore {
namespace {

Dmp random_dmp(unsigned seed, Eigen::Index dimensions = 3) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  const auto draw = [&] { return normal(generator); };
  return Dmp(Eigen::VectorXd::NullaryExpr(dimensions, draw), Eigen::VectorXd::NullaryExpr(dimensions, draw),
             100 * RowMatrix::NullaryExpr(dimensions, 20, draw));
}

// 5.1 by RK4 at 1e-4 of the motion.
Eigen::MatrixXd by_rk4(const Dmp& dmp, int samples) {
  const DmpConfig& c = dmp.config();
  const Eigen::Index D = dmp.dimensions();
  const auto slope = [&](double s, const Eigen::MatrixXd& state) {
    const Eigen::VectorXd x = Eigen::VectorXd::Constant(1, std::exp(-c.phase_decay * s));
    const Eigen::VectorXd f = dmp.weights() * basis(x, c).row(0).transpose();
    Eigen::MatrixXd rate(D, 2);
    rate.col(0) = state.col(1);
    rate.col(1) = c.stiffness * (c.damping * (dmp.goal() - state.col(0)) - state.col(1)) + f;
    return rate;
  };
  Eigen::MatrixXd positions(samples, D), state(D, 2);
  state << dmp.start(), Eigen::VectorXd::Zero(D);
  const int inner = 10000 / (samples - 1);
  const double h = 1.0 / (inner * (samples - 1));
  for (int k = 0; k <= inner * (samples - 1); ++k) {
    if (k % inner == 0) positions.row(k / inner) = state.col(0).transpose();
    const double s = k * h;
    const Eigen::MatrixXd a = slope(s, state), b = slope(s + h / 2, state + h / 2 * a);
    const Eigen::MatrixXd d = slope(s + h / 2, state + h / 2 * b), e = slope(s + h, state + h * d);
    state += h / 6 * (a + 2 * b + 2 * d + e);
  }
  return positions;
}

TEST(Dmp, rolls_out_as_dense_rk4_does) {
  const Dmp dmp = random_dmp(1);
  EXPECT_LT((dmp.rollout(11).positions - by_rk4(dmp, 11)).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Dmp, steps_as_it_rolls_out) {
  const Dmp dmp = random_dmp(2);
  DmpStepper stepper = dmp.begin({.rate = 0.5});
  for (const double dt : {0.3, 0.01, 0.69, 1.0}) stepper.step(dt);
  const Eigen::MatrixXd end = dmp.rollout(2, {.rate = 0.5}).positions.row(1);
  EXPECT_LT((stepper.position() - end.transpose()).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Dmp, steps_without_allocating) {
  if (!test::counts_allocations) GTEST_SKIP() << "nothing counts allocations in this build";
  DmpStepper stepper = random_dmp(3).begin();
  stepper.step(0.01);
  const long before = test::allocation_count();
  for (int i = 0; i < 10; ++i) stepper.step(0.01);
  EXPECT_EQ(test::allocation_count(), before);
}

TEST(Dmp, refuses_a_demonstration_of_two_samples) {
  EXPECT_THROW(Dmp::fit(RowMatrix::Zero(2, 1)), std::invalid_argument);
}

}  // namespace
}  // namespace lfdcore
