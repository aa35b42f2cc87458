#include "lfdcore/control/stopping_rollouts.hpp"

#include <gtest/gtest.h>

#include <random>

namespace lfdcore {
namespace {

using Random = std::mt19937_64;

double draw(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

Twist2 any_twist(Random& random) { return {draw(random, -0.4, 1), draw(random, -1, 1)}; }

// The pose and the way at the end of each roll-out.
struct End {
  Pose2 pose;
  double way = 0, turn = 0;
};

End end_of(StoppingRollouts& rollouts, int i) {
  End end;
  for (const RolloutArc& arc : rollouts.arcs(i)) {
    end.pose = integrate(arc.start, arc.twist, arc.duration);
    end.way += arc.twist.linear * arc.duration;
    end.turn += arc.twist.angular * arc.duration;
  }
  return end;
}

// A chair in steps of 1 ms whose limits differ by shares that may change at any time.
struct Chair {
  Pose2 pose;
  Twist2 twist;
  double way = 0, turn = 0;

  void step(const Twist2& command, const MotionLimits& limits, double linear_share, double angular_share) {
    const Twist2 next = approach(twist, command, limits, 0.001);
    const Twist2 mean{(twist.linear + next.linear) / 2 * linear_share,
                      (twist.angular + next.angular) / 2 * angular_share};
    pose = integrate(pose, mean, 0.001);
    way += mean.linear * 0.001;
    turn += mean.angular * 0.001;
    twist = next;
  }
};

MotionLimits within(const MotionErrors& errors, Random& random) {
  const auto share = [&] { return 1 + errors.dynamics * draw(random, -1, 1); };
  MotionLimits limits;
  limits.linear_acceleration *= share();
  limits.linear_braking *= share();
  limits.angular_acceleration *= share();
  return limits;
}

TEST(StoppingRollouts, without_errors_are_the_one_motion_of_the_declared_chair) {
  Random random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const Twist2 current = any_twist(random), command = any_twist(random);
    const TimedTwist pending[] = {{any_twist(random), 0.12}, {any_twist(random), 0.031}};
    StoppingRollouts rollouts({}, {});
    rollouts.start(current, pending);
    rollouts.end_with(command, 0.1, 0);
    ASSERT_EQ(rollouts.count(), 1);
    Chair chair{{}, current};
    for (int ms = 0; ms < 1300; ++ms) {
      chair.step(ms < 120 ? pending[0].twist : ms < 151 ? pending[1].twist : ms < 251 ? command : Twist2{}, {}, 1, 1);
    }
    const End end = end_of(rollouts, 0);
    EXPECT_NEAR(end.pose.x, chair.pose.x, 5e-4);
    EXPECT_NEAR(end.pose.y, chair.pose.y, 5e-4);
    EXPECT_NEAR(end.turn, chair.turn, 5e-4);
  }
}

TEST(StoppingRollouts, hold_between_them_way_and_turn_of_every_chair_within_the_errors) {
  const MotionErrors errors{0.2, 0.05};
  Random random(2);
  double widest = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const Twist2 current = any_twist(random), command = any_twist(random);
    const TimedTwist pending[] = {{any_twist(random), 0.15}};
    StoppingRollouts rollouts({}, errors);
    rollouts.start(current, pending);
    rollouts.end_with(command, 0.1, 0.05);
    ASSERT_EQ(rollouts.count(), 4);
    double low = 1e9, high = -1e9, left = -1e9, right = 1e9;
    for (int i = 0; i < 4; ++i) {
      const End end = end_of(rollouts, i);
      low = std::min(low, end.way);
      high = std::max(high, end.way);
      right = std::min(right, end.turn);
      left = std::max(left, end.turn);
    }
    widest = std::max(widest, high - low);
    const int late = static_cast<int>(draw(random, 250, 301));
    Chair chair{{}, current};
    MotionLimits limits = within(errors, random);
    for (int ms = 0; ms < 1800; ++ms) {
      if (trial % 2 == 0 && ms % 20 == 0) limits = within(errors, random);
      const Twist2 now = ms < 150 ? pending[0].twist : ms < late ? command : Twist2{};
      chair.step(now, limits, 1 + 0.05 * draw(random, -1, 1), 1 + 0.05 * draw(random, -1, 1));
    }
    EXPECT_GE(chair.way, low - 1e-9);
    EXPECT_LE(chair.way, high + 1e-9);
    EXPECT_GE(chair.turn, right - 1e-9);
    EXPECT_LE(chair.turn, left + 1e-9);
    EXPECT_GE(rollouts.travel(), std::abs(chair.way));
    EXPECT_GE(rollouts.turning(), std::abs(chair.turn));
  }
  EXPECT_LT(widest, 0.5);
}

TEST(StoppingRollouts, straight_on_and_on_the_spot_are_one_the_farthest) {
  StoppingRollouts rollouts({}, {0.2, 0.05});
  rollouts.start({0.5, 0}, {});
  rollouts.end_with({0.6, 0}, 0.1, 0.05);
  ASSERT_EQ(rollouts.count(), 1);
  EXPECT_NEAR(end_of(rollouts, 0).way, rollouts.travel(), 1e-12);
  rollouts.start({0, -0.5}, {});
  rollouts.end_with({0, -0.6}, 0.1, 0.05);
  ASSERT_EQ(rollouts.count(), 1);
  EXPECT_NEAR(-end_of(rollouts, 0).turn, rollouts.turning(), 1e-12);
  rollouts.start({0, -0.1}, {});
  rollouts.end_with({0, 0.6}, 0.1, 0.05);  // first one way, then the other
  EXPECT_EQ(rollouts.count(), 2);
  rollouts.end_with({0.1, 0}, 0.1, 0.05);
  EXPECT_EQ(rollouts.count(), 4);
}

TEST(StoppingRollouts, take_as_long_as_the_slowest_braking) {
  StoppingRollouts rollouts({}, {0.2, 0});
  rollouts.start({1, 0}, {});
  rollouts.end_with({1, 0}, 0.1, 0.05);
  EXPECT_NEAR(rollouts.duration(), 0.15 + 1 / (1.5 * 0.8), 1e-12);
}

}  // namespace
}  // namespace lfdcore
