#include "lfdcore/control/supervisor.hpp"

#include <gtest/gtest.h>

#include <random>

namespace lfdcore {
namespace {

Path wall_ahead(double x) {
  Path points(81, 2);
  for (int i = 0; i < 81; ++i) points.row(i) << x, -2 + 0.05 * i;
  return points;
}

// Points [m] of a random world: clusters and walls, none within `free` of the origin.
Path random_world(std::mt19937& random, double free) {
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<Eigen::Vector2d> kept;
  for (int wall = 0; wall < 14; ++wall) {
    const Eigen::Vector2d from(4 * unit(random), 4 * unit(random));
    const double yaw = pi * unit(random), length = 1 + unit(random);
    for (double s = 0; s < length; s += 0.03) {
      const Eigen::Vector2d p = from + s * Eigen::Vector2d(std::cos(yaw), std::sin(yaw));
      if (p.norm() > free) kept.push_back(p);
    }
  }
  Path points(static_cast<Eigen::Index>(kept.size()), 2);
  for (std::size_t i = 0; i < kept.size(); ++i) points.row(static_cast<Eigen::Index>(i)) = kept[i].transpose();
  return points;
}

// The chair itself, integrated in 2 ms steps; counts the steps in which a point is in the footprint.
struct Chair {
  Pose2 pose;
  Twist2 twist;
  double least_clearance = 1e9;
  int every = 5;

  void drive(const Twist2& command, double duration, const ObstaclePoints& world, const MotionLimits& limits) {
    const int steps = static_cast<int>(std::lround(duration / 0.002));
    for (int i = 0; i < steps; ++i) {
      const Twist2 next = approach(twist, command, limits, 0.002);
      pose = integrate(pose, {(twist.linear + next.linear) / 2, (twist.angular + next.angular) / 2}, 0.002);
      twist = next;
      if (i % every == 0) least_clearance = std::min(least_clearance, world.clearance(pose, {}));
    }
  }
};

TEST(Supervisor, never_lets_a_point_into_the_footprint_whatever_the_driver_does) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  const MotionLimits limits;
  Supervisor supervisor;
  int changed = 0, stopped = 0, moving = 0, ticks = 0;
  double least = 1e9;
  for (int world = 0; world < 12; ++world) {
    const Path points = random_world(random, 1.0);
    const ObstaclePoints obstacles(points);
    Chair chair;
    Twist2 wanted;
    for (int i = 0; i < 300; ++i, ++ticks) {
      if (i % 7 == 0) wanted = {0.4 + unit(random), 1.3 * unit(random)};  // also beyond the limits
      const auto result =
          supervisor.filter(wanted, chair.twist, ObstaclePoints(transform(chair.pose.inverse(), points)));
      ASSERT_LE(std::abs(result.twist.linear), std::abs(wanted.linear) + 1e-12);
      ASSERT_LE(result.twist.linear, limits.max_linear);
      ASSERT_GE(result.twist.linear, -limits.max_reverse);
      ASSERT_GE(result.twist.linear * wanted.linear, 0);
      ASSERT_LE(std::abs(result.twist.angular), limits.max_angular);
      ASSERT_GE(result.scale, 0);
      changed += result.changed;
      stopped += result.stopped;
      chair.drive(result.twist, 0.1, obstacles, limits);
      ASSERT_GT(chair.least_clearance, 0) << "world " << world << " tick " << i;
      moving += std::abs(chair.twist.linear) > 0.05;
    }
    least = std::min(least, chair.least_clearance);
  }
  EXPECT_GT(least, 0.003);  // passing_margin less the tolerance of the swept test
  EXPECT_GT(changed, ticks / 4);
  EXPECT_GT(stopped, 5);
  EXPECT_GT(moving, ticks / 10);
}

double margin_at(double linear, const SupervisorConfig& config) {
  const double share = std::min(linear / config.margin_linear, 1.0);
  return config.least_margin + share * (config.margin - config.least_margin);
}

TEST(Supervisor, a_command_is_refused_exactly_when_stopping_takes_more_than_the_room_there_is) {
  const MotionLimits limits;
  const SupervisorConfig config;
  std::mt19937 random(6);
  std::uniform_real_distribution<double> speed(0.3, 1.0);
  for (int trial = 0; trial < 100; ++trial) {
    const CommandTiming timing{0.05 * (1 + trial % 4), 0.025 * (1 + trial % 3)};
    Supervisor supervisor({}, limits, config, timing);
    const double v = speed(random);
    const double follow = timing.period + timing.jitter, braking = limits.linear_braking * (1 - config.dynamics_error);
    const double needed = v * (1 + config.speed_error) * (follow + v / (2 * braking)) + margin_at(v, config);
    const auto filter = [&](double room) {
      return supervisor.filter({v, 0}, {v, 0}, ObstaclePoints(wall_ahead(0.8 + room)));
    };
    EXPECT_FALSE(filter(needed + 0.003).changed) << v;
    EXPECT_TRUE(filter(needed - 0.003).changed) << v;
  }
}

TEST(Supervisor, agrees_with_rolling_out_in_millisecond_steps) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  const MotionLimits limits;
  SupervisorConfig config;  // no errors: as declared
  config.dynamics_error = config.speed_error = 0;
  config.least_margin = config.margin;
  const CommandTiming timing{0.1, 0};
  Supervisor supervisor({}, limits, config, timing);
  int admissible = 0, refused = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const Path points = random_world(random, 0.95);
    const Twist2 wanted{0.6 + 0.4 * unit(random), unit(random)}, current{0.6 + 0.4 * unit(random), unit(random)};
    const TimedTwist pending[] = {{{0.3 * unit(random), unit(random)}, 0.1}, {{unit(random), 0.0}, 0.06}};
    Chair chair{{}, current, 1e9, 1};
    for (const TimedTwist& command : pending)
      chair.drive(command.twist, command.duration, ObstaclePoints(points), limits);
    chair.drive(wanted, timing.period, ObstaclePoints(points), limits);
    chair.drive({}, 1.0, ObstaclePoints(points), limits);
    const double least = chair.least_clearance;
    const double margin = std::min(config.margin, ObstaclePoints(points).clearance({}, {}));
    const auto result = supervisor.filter(wanted, current, ObstaclePoints(points), pending);
    if (least > margin + 1e-4) EXPECT_FALSE(result.changed) << trial;
    if (least < margin - 3e-3) EXPECT_TRUE(result.changed) << trial;
    admissible += least > margin;
    refused += least < margin;
  }
  EXPECT_GT(admissible, 50);
  EXPECT_GT(refused, 20);
}

TEST(Supervisor, passes_everything_where_nothing_is_near) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> unit(-1, 1);
  Supervisor supervisor;
  for (int trial = 0; trial < 200; ++trial) {
    const Twist2 wanted{unit(random) > 0 ? 0.9 : -0.3, unit(random)};
    const auto result = supervisor.filter(wanted, {unit(random), unit(random)}, ObstaclePoints(wall_ahead(3.5)));
    EXPECT_FALSE(result.changed);
    EXPECT_EQ(result.twist.linear, wanted.linear);
    EXPECT_EQ(result.twist.angular, wanted.angular);
    EXPECT_EQ(result.scale, 1);
  }
  EXPECT_FALSE(supervisor.filter({1, 1}, {}, {}).changed);
}

TEST(Supervisor, slows_on_the_same_arc_before_it_tries_another) {
  Supervisor supervisor;
  const auto result = supervisor.filter({0.8, 0.2}, {0.4, 0.1}, ObstaclePoints(wall_ahead(0.98)));
  EXPECT_TRUE(result.changed);
  EXPECT_GT(result.scale, 0.25);
  EXPECT_LT(result.scale, 1);
  EXPECT_NEAR(result.twist.angular / result.twist.linear, 0.25, 1e-12);
}

TEST(Supervisor, drives_up_to_a_wall_and_stands_near_the_least_margin) {
  Supervisor supervisor;
  const Path wall = wall_ahead(2.5);
  Chair chair;
  for (int i = 0; i < 200; ++i) {
    const auto seen = ObstaclePoints(transform(chair.pose.inverse(), wall));
    chair.drive(supervisor.filter({0.7, 0}, chair.twist, seen).twist, 0.1, ObstaclePoints(wall), {});
  }
  EXPECT_EQ(chair.twist.linear, 0);
  EXPECT_GT(chair.least_clearance, 0.013);
  EXPECT_LT(chair.least_clearance, 0.05);  // near enough to dock
}

TEST(Supervisor, stops_at_a_wall_and_says_so) {
  Supervisor supervisor;
  const auto result = supervisor.filter({0.7, 0}, {0.7, 0}, ObstaclePoints(wall_ahead(0.95)));
  EXPECT_EQ(result.twist.linear, 0);
  EXPECT_TRUE(result.stopped);
  EXPECT_EQ(result.scale, 0);
  EXPECT_FALSE(supervisor.filter({}, {0.7, 0}, ObstaclePoints(wall_ahead(0.95))).stopped);
}

// hazard: The chair is frozen | requirement: it backs out of points within margin and outline | count: 1 case
TEST(Supervisor, can_always_back_out_when_points_are_within_the_margin_or_the_footprint) {
  Supervisor supervisor;
  for (const double gap : {0.02, 0.005, 0.0005, 0.0, -0.005, -0.015, -0.1}) {
    const ObstaclePoints wall(wall_ahead(0.8 + gap));
    const auto back = supervisor.filter({-0.2, 0}, {}, wall);
    EXPECT_FALSE(back.changed) << gap;
    EXPECT_TRUE(back.keeps) << gap;
    if (gap <= 0.005) EXPECT_EQ(supervisor.filter({0.3, 0}, {}, wall).twist.linear, 0) << gap;
  }
}

// hazard: The chair is frozen | requirement: it slides along a wall that is within the margin | count: 1 case
TEST(Supervisor, slides_along_a_wall_that_is_within_the_margin) {
  Path wall(200, 2);
  for (int i = 0; i < 200; ++i) wall.row(i) << -3 + 0.05 * i, 0.353;  // 3 mm beside the chair
  Supervisor supervisor;
  for (const double linear : {0.5, -0.3, 0.1}) {
    const auto straight = supervisor.filter({linear, 0}, {}, ObstaclePoints(wall)).twist;
    EXPECT_GE(std::abs(straight.linear), 0.1 - 1e-9);
    EXPECT_EQ(straight.angular, 0);
    const auto turning = supervisor.filter({linear, 0.5}, {}, ObstaclePoints(wall)).twist;
    EXPECT_GE(std::abs(turning.linear), 0.1 - 1e-9);
    EXPECT_EQ(turning.angular, 0);
  }
}

// hazard: Something touches the chair's side | requirement: it takes nothing from the margin to others | count: 1 case
TEST(Supervisor, a_point_inside_the_footprint_takes_nothing_from_the_margin_to_others) {
  const Path wall = wall_ahead(1.0);
  for (const double depth : {0.01, 0.03, 0.1}) {
    Supervisor supervisor;
    Chair chair;
    for (int i = 0; i < 100; ++i) {
      Path seen(82, 2);
      seen << transform(chair.pose.inverse(), wall), Eigen::RowVector2d(0.4, 0.35 - depth);  // a person at the side
      chair.drive(supervisor.filter({0.7, 0}, chair.twist, ObstaclePoints(seen)).twist, 0.1, ObstaclePoints(wall), {});
    }
    EXPECT_GT(chair.pose.x, 0.15) << depth;
    EXPECT_GT(chair.least_clearance, 0.013) << depth;
  }
}

TEST(Supervisor, the_driver_gets_slower_through_a_narrow_gap_not_stuck) {
  Path gap(80, 2);  // .84 m wide between two posts rows, chair .70 m: 7 cm each side
  for (int i = 0; i < 40; ++i) {
    gap.row(i) << 1.5, 0.42 + 0.05 * i;
    gap.row(40 + i) << 1.5, -0.42 - 0.05 * i;
  }
  Supervisor supervisor;
  Chair chair;
  for (int i = 0; i < 150; ++i) {
    const auto seen = ObstaclePoints(transform(chair.pose.inverse(), gap));
    chair.drive(supervisor.filter({0.5, 0}, chair.twist, seen).twist, 0.1, ObstaclePoints(gap), {});
  }
  EXPECT_GT(chair.pose.x, 3);
  EXPECT_GT(chair.least_clearance, 0.06);
}

// hazard: The chair goes where no beam has seen | requirement:
// at most .1 m/s ahead, .15 m/s back, .2 rad/s | count: 1 case
TEST(Supervisor, enters_space_that_no_beam_has_seen_at_creep_speeds_only) {
  const ObstaclePoints nothing, ahead(wall_ahead(1.0)), behind(wall_ahead(-0.5));
  Path beside(1, 2);
  beside << 0.75, 0.352;
  const SupervisorConfig config;
  Supervisor supervisor;
  const auto filter = [&](const Twist2& wanted, const ObstaclePoints& unseen) {
    return supervisor.filter(wanted, {}, nothing, {}, 0, unseen).twist;
  };
  EXPECT_EQ(filter({0.8, 0}, {}).linear, 0.8);
  EXPECT_EQ(filter({0.8, 0}, behind).linear, 0.8);
  Chair chair;
  for (int i = 0; i < 100; ++i) {  // until the border lies inside the outline, and on
    const ObstaclePoints border(transform(chair.pose.inverse(), ahead.points()));
    const Twist2 given = supervisor.filter({0.8, 0}, chair.twist, nothing, {}, 0, border).twist;
    if (chair.pose.x > 0.2 && chair.pose.x < 0.3) EXPECT_LE(chair.twist.linear, config.creep_linear + 1e-9);
    if (chair.pose.x < 1) EXPECT_GE(given.linear, config.creep_linear - 1e-9);
    chair.drive(given, 0.1, nothing, {});
  }
  EXPECT_GT(chair.pose.x, 0.5);
  EXPECT_NEAR(filter({-0.4, 0}, ObstaclePoints(wall_ahead(-0.355))).linear, -config.creep_reverse, 1e-9);
  EXPECT_NEAR(filter({0, 0.8}, ObstaclePoints(beside)).angular, config.creep_angular, 1e-9);
  EXPECT_EQ(filter({0.1, 0.2}, ObstaclePoints(wall_ahead(0.81))).linear, 0.1);
}

TEST(Supervisor, stands_when_something_that_walks_towards_it_arrives) {
  SupervisorConfig config;
  config.obstacle_speed = 0.6;
  Supervisor supervisor({}, {}, config);
  for (const double age : {0.0, 0.3}) {
    Chair chair;
    double x = 5, touching_at = -1;
    for (int i = 0; i < 120 && touching_at < 0; ++i, x -= 0.06) {
      const ObstaclePoints seen(transform(chair.pose.inverse(), wall_ahead(x + 0.6 * age)));
      const Twist2 given = supervisor.filter({0.9, 0.1}, chair.twist, seen, {}, age).twist;
      for (int k = 0; k < 10; ++k) {
        chair.drive(given, 0.01, ObstaclePoints(wall_ahead(x - 0.006 * k)), {});
        if (chair.least_clearance == 0) touching_at = std::hypot(chair.twist.linear, chair.twist.angular);
      }
    }
    EXPECT_EQ(touching_at, 0) << age;
    EXPECT_GT(chair.pose.x, 0.5);
  }
}

TEST(Supervisor, lets_the_chair_stand_and_drive_away_whatever_approaches) {
  SupervisorConfig config;
  config.obstacle_speed = 1;
  Supervisor supervisor({}, {}, config);
  for (const double gap : {-0.05, 0.001, 0.02, 0.3}) {
    const ObstaclePoints near(wall_ahead(0.8 + gap));
    EXPECT_TRUE(supervisor.filter({}, {}, near, {}, 0.5).keeps);
    EXPECT_FALSE(supervisor.filter({-0.1, 0}, {}, near, {}, 0.5).changed);
  }
}

// A person's disc, as points on its rim.
Path person_at(double x, double y) {
  Path rim(24, 2);
  for (int i = 0; i < 24; ++i) rim.row(i) << x + 0.25 * std::cos(2 * pi * i / 24), y + 0.25 * std::sin(2 * pi * i / 24);
  return rim;
}

// hazard: A person walks in the chair's way | requirement: the moving nose meets nobody who walks at up to the walking
// speed | count: 300 walks
TEST(Supervisor, the_moving_nose_meets_no_walker) {
  std::mt19937 random(21);
  std::uniform_real_distribution<double> unit(-1, 1);
  int met = 0, met_unwarned = 0;
  for (int walk = 0; walk < 300; ++walk) {
    for (const bool warned : {true, false}) {
      Supervisor supervisor;
      Chair chair;
      const double speed = 1.1 + 0.4 * unit(random), from = 1.2 * unit(random), aim_x = 1 + unit(random);
      Eigen::Vector2d person(4 * std::cos(from) + 0.8, 4 * std::sin(from));
      const Eigen::Vector2d step = speed * 0.01 * (Eigen::Vector2d(aim_x, 0.4 * unit(random)) - person).normalized();
      const Twist2 wanted{1, 0.3 * unit(random)};
      for (int tick = 0; tick < 60; ++tick) {
        const ObstaclePoints seen(transform(chair.pose.inverse(), person_at(person.x(), person.y())));
        const ObstaclePoints walkers = warned ? seen : ObstaclePoints();
        const Twist2 given = supervisor.filter(wanted, chair.twist, seen, {}, 0, {}, walkers).twist;
        bool touches = false;
        for (int k = 0; k < 10 && !touches; ++k) {
          person += step;
          chair.drive(given, 0.01, ObstaclePoints(person_at(person.x(), person.y())), {});
          touches = chair.least_clearance == 0;
        }
        if (!touches) continue;
        const bool nose = (chair.pose.inverse() * person).x() > Footprint().front;
        (warned ? met : met_unwarned) += nose && chair.twist.linear > 0.02;
        break;
      }
    }
  }
  EXPECT_EQ(met, 0);
  EXPECT_GT(met_unwarned, 50);
}

TEST(Supervisor, creeps_straight_on_past_what_is_too_near_for_any_turn) {
  Path posts(4, 2);  // the door's posts: .010 m beside the way on both sides
  posts << 0.9, 0.36, 0.9, -0.36, 1.1, 0.36, 1.1, -0.36;
  Supervisor supervisor;
  Chair chair;
  for (int i = 0; i < 300; ++i) {
    const ObstaclePoints seen(transform(chair.pose.inverse(), posts));
    chair.drive(supervisor.filter({0.6, 0}, chair.twist, seen).twist, 0.1, ObstaclePoints(posts), {});
  }
  EXPECT_GT(chair.pose.x, 1.5);
  EXPECT_GT(chair.least_clearance, 0.005 - 0.002);
}

TEST(Supervisor, refuses_bad_input) {
  Supervisor supervisor;
  EXPECT_THROW(supervisor.filter({NAN, 0}, {}, {}), std::invalid_argument);
  EXPECT_THROW(supervisor.filter({}, {0, INFINITY}, {}), std::invalid_argument);
  EXPECT_THROW(supervisor.filter({}, {1e6, 0}, {}), std::invalid_argument);
  const TimedTwist endless[] = {{{}, 6}, {{}, 6}}, wild[] = {{{0, NAN}, 0.1}};
  EXPECT_THROW(supervisor.filter({}, {}, {}, endless), std::invalid_argument);
  EXPECT_THROW(supervisor.filter({}, {}, {}, wild), std::invalid_argument);
  EXPECT_THROW(supervisor.filter({}, {}, {}, {}, -0.1), std::invalid_argument);
  for (const CommandTiming& timing : {CommandTiming{0.1, -0.05}, CommandTiming{0, 0}, CommandTiming{NAN, 0}})
    EXPECT_THROW(Supervisor({}, {}, {}, timing), std::invalid_argument);
  SupervisorConfig config;
  config.least_margin = 2 * config.margin;
  EXPECT_THROW(Supervisor({}, {}, config), std::invalid_argument);
  MotionLimits limits;
  limits.linear_braking = 1e-3;
  EXPECT_THROW(Supervisor({}, limits), std::invalid_argument);
  EXPECT_THROW(Supervisor({0.8, 0.35, 0}), std::invalid_argument);
}

}  // namespace
}  // namespace lfdcore
