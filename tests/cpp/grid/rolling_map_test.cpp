#include "lfdcore/grid/rolling_map.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "../allocation_count.hpp"
#include "scanned_world.hpp"

namespace lfdcore {
namespace {

LaserScan ring(int step) {
  LaserScan scan;
  for (int i = 0; i < 181; ++i) scan.ranges.push_back(2.0f + 0.01f * static_cast<float>((i * 7 + step * 13) % 40));
  scan.ranges[3] = std::numeric_limits<float>::infinity();
  scan.ranges[4] = std::numeric_limits<float>::quiet_NaN();
  return scan;
}

TEST(RollingMap, inserts_scans_on_a_drive_without_allocating_once_its_buffers_have_grown) {
  if (!test::counts_allocations) GTEST_SKIP() << "nothing counts allocations in this build";
  RollingMap map({.duration = 2.0, .radius = 4.0});
  long allocations = 0;
  for (int step = 0; step < 200; ++step) {
    const LaserScan scan = ring(step);
    const Pose2 base{0.05 * step, 0.01 * step, 0.02 * step};
    const long before = test::allocation_count();
    map.insert(0.1 * step, scan, {0.70, 0, 0}, base);
    if (step >= 100) allocations += test::allocation_count() - before;
  }
  EXPECT_EQ(allocations, 0);
  EXPECT_GT(map.size(), 100u);
}

TEST(RollingMap, keeps_its_state_when_it_refuses_a_scan) {
  RollingMap map;
  map.insert(1.0, ring(0), {0.70, 0, 0}, {});
  const std::size_t size = map.size();
  LaserScan broken = ring(1);
  broken.angle_increment = 0;
  EXPECT_THROW(map.insert(2.0, broken, {0.70, 0, 0}, {}), std::invalid_argument);
  EXPECT_THROW(map.insert(0.5, ring(1), {0.70, 0, 0}, {}), std::invalid_argument);
  EXPECT_EQ(map.size(), size);
}

using test::ScannedWorld;

const Pose2 mounting{0.70, 0, 0};
const LaserScan blind{.ranges = {std::numeric_limits<float>::quiet_NaN()}};

double distance_to(const ObstaclePoints& seen, const Eigen::Vector2d& place) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& point : seen.points().rowwise()) nearest = std::min(nearest, (point - place.transpose()).norm());
  return nearest;
}

void see(RollingMap& map, ScannedWorld& world, double stamp, const Pose2& base) {
  map.insert(stamp, world.scan(base * mounting), mounting, base);
}

RollingMapConfig long_memory(double noise) { return {.duration = 120, .radius = 4, .range_noise = noise}; }

struct Spread {
  double nearest = 1e9, farthest = -1e9, square = 0;
  int count = 0;
  double rms() const { return std::sqrt(square / count); }
};

// How far the points of a chair that looks at a wall across its way lie behind it.
Spread behind_wall_ahead(const RollingMap& map, double wall) {
  Spread spread;
  const ObstaclePoints seen = map.obstacles({});
  for (const double x : seen.points().col(0)) {
    const double error = x - wall;
    spread.nearest = std::min(spread.nearest, error);
    spread.farthest = std::max(spread.farthest, error);
    spread.square += error * error;
    ++spread.count;
  }
  return spread;
}

// Beams of 1 degree meet it every 11 cm.
TEST(RollingMap, a_wall_seen_at_a_grazing_angle_has_no_holes_that_a_corner_of_the_chair_fits_into) {
  RollingMap map({.duration = 30, .range_noise = 0.001});
  ScannedWorld world{.walls = {{-20, 0.35, 20, 0.35}}, .noise = 0.001};
  for (int k = 1; k <= 50; ++k) see(map, world, 0.1 * k, {});
  const ObstaclePoints seen = map.obstacles({});
  for (double x = 1; x < 1.9; x += 0.001) EXPECT_LT(distance_to(seen, {x, 0.35}), 0.016) << x;
}

class Noise : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(RollingMap, Noise, testing::Values(0.01, 0.03, 0.06));

// 1 / sqrt(100) of the noise is what the mean of 100 hits has; the worst of some 100 points has 3 to 4 times that.
TEST_P(Noise, a_wall_seen_from_a_standing_chair_is_one_sharp_row_of_points) {
  const double noise = GetParam();
  RollingMap map(long_memory(noise));
  ScannedWorld world{.walls = {{3, -20, 3, 20}}, .noise = noise};
  for (int k = 1; k <= 1000; ++k) {
    see(map, world, 0.1 * k, {});
    if (k % 200 != 0) continue;
    EXPECT_LE(map.size(), 181u);
    const ObstaclePoints seen = map.obstacles({});
    for (const double u : seen.uncertainty()) EXPECT_LE(u, 0.01);
  }
  const Spread spread = behind_wall_ahead(map, 3);
  if (3 * noise / 10 < 0.015) {  // else each point is given with a nearer one
    EXPECT_LT(spread.rms(), 0.12 * noise);
    EXPECT_LT(spread.farthest - spread.nearest, 0.8 * noise);
  }
  EXPECT_GT(spread.nearest, -0.5 * noise);
}

// Points beside the chair: at most 80 a metre of wall, and never farther than the wall by more than 3 of the standard
// errors of 20 hits, however many scans went by.
TEST_P(Noise, a_wall_driven_along_does_not_grow) {
  const double noise = GetParam(), gap = 0.9;
  RollingMap map(long_memory(noise));
  ScannedWorld world{.walls = {{-30, gap, 60, gap}}, .noise = noise};
  Pose2 base;
  for (int k = 0; k < 400; ++k) {
    base = {0.03 * k, 0, 0.02 * std::sin(0.3 * k)};
    see(map, world, 0.1 * k, base);
  }
  const ObstaclePoints seen = map.obstacles(base);
  int beside = 0, off = 0;
  for (Eigen::Index i = 0; i < seen.points().rows(); ++i) {
    const Eigen::Vector2d place = base * Eigen::Vector2d(seen.points().row(i));
    if (std::abs(place.x() - base.x) > 1) continue;
    ++beside;
    off += place.y() - gap > 0.7 * noise || place.y() - gap < -2.5 * noise;
  }
  EXPECT_GT(beside, 60);
  EXPECT_LT(beside, 2 * 2 * 80);  // each with a nearer one at most
  EXPECT_LE(off, beside / 50);
}

// What the supervisor asks: how near the post is to the body. A point is within 0.015 m of its hits.
TEST_P(Noise, a_post_driven_past_comes_no_farther_than_it_is) {
  const double noise = GetParam();
  for (const double side : {0.02, 0.06, 0.2}) {
    ScannedWorld world{.walls = {{9, -9, 9, 9}}, .noise = noise};
    world.add_box(2.5, 0.5, 2.5 + side, 0.5 + side);
    RollingMap map(long_memory(noise));
    for (int k = 0; k < 90; ++k) {
      const Pose2 base{0.05 * k, 0, 0.05 * std::sin(0.2 * k)};
      see(map, world, 0.1 * k, base);
      if (base.x < 1.6 || base.x > 2.8) continue;
      const Path corner = Path::Ones(1, 2).array().rowwise() * Eigen::Array<double, 1, 2>(2.5, 0.5);
      const ObstaclePoints seen = map.obstacles(base), truth(corner);
      double told = std::numeric_limits<double>::infinity();
      for (Eigen::Index i = 0; i < seen.points().rows(); ++i)
        told = std::min(told, ObstaclePoints(seen.points().row(i)).clearance({}, {}) - seen.uncertainty()[i]);
      EXPECT_LT(told, truth.clearance(base, {}) + 0.02) << "side " << side << " at x " << base.x;
    }
  }
}

TEST(RollingMap, a_wall_out_of_view_is_remembered_for_its_duration_whatever_is_seen_elsewhere) {
  RollingMap map(long_memory(0.01));
  ScannedWorld world{.walls = {{-5, 0.6, 5, 0.6}, {6, -9, 6, 9}}};
  for (int k = 0; k <= 30; ++k) see(map, world, 0.1 * k, {0.05 * k, 0, 0});
  const Pose2 parked{1.5, 0, 0};
  const double clearance = map.obstacles(parked).clearance({}, {});
  EXPECT_NEAR(clearance, 0.25, 0.03);
  for (int k = 31; k <= 1200; k += 10) see(map, world, 0.1 * k, parked);
  EXPECT_NEAR(map.obstacles(parked).clearance({}, {}), 0.25, 0.03);
}

// Nearer than the truth by what is uncertain; farther never by more than what the latest scan is off by.
// hazard: Fused points lag behind what moves | requirement: never farther than it is | count: 1 case
TEST(RollingMap, an_obstacle_that_comes_nearer_is_never_given_farther_than_it_is) {
  for (const double noise : {0.01, 0.03})
    for (const double speed : {0.2, 0.5, 1.4}) {
      RollingMap map(long_memory(noise));
      for (int k = 0; 3.5 - 0.1 * k * speed > 1.2; ++k) {
        const double plate = 3.5 - 0.1 * k * speed;
        ScannedWorld world{.walls = {{plate, -0.3, plate, 0.3}, {8, -9, 8, 9}}, .noise = noise};
        world.rng.seed(k);
        see(map, world, 0.1 * k, {});
        const double told = map.obstacles({}).points().col(0).minCoeff();
        EXPECT_LT(told, plate + 0.01) << "noise " << noise << " speed " << speed << " at " << plate;
        EXPECT_GT(told, plate - 7 * noise) << "noise " << noise << " speed " << speed << " at " << plate;
      }
    }
}

// Behind a thing that moves away, a point stays for 3 scans in which beams go on behind it, by 3 standard errors more.
TEST(RollingMap, an_obstacle_that_moves_away_leaves_nothing_behind_for_long) {
  for (const double noise : {0.01, 0.03})
    for (const double speed : {0.2, 0.5, 1.4}) {
      RollingMap map(long_memory(noise));
      for (int k = 0; 1.5 + 0.1 * k * speed < 3; ++k) {
        const double plate = 1.5 + 0.1 * k * speed;
        ScannedWorld world{.walls = {{plate, -0.3, plate, 0.3}, {8, -9, 8, 9}}, .noise = noise};
        world.rng.seed(k);
        see(map, world, 0.1 * k, {});
        const double told = map.obstacles({}).points().col(0).minCoeff();
        EXPECT_GT(told, plate - 0.3 * speed - 0.06 - 7 * noise) << "noise " << noise << " speed " << speed;
      }
    }
}

TEST(RollingMap, both_faces_of_a_thin_board_are_kept_where_they_are) {
  RollingMap map(long_memory(0.01));
  ScannedWorld world;
  world.add_box(1.5, 1.0, 4.5, 1.018);
  double stamp = 0;
  for (double x = 0; x < 4.6; x += 0.03) see(map, world, stamp += 0.1, {x, 0.0, 0});
  for (double turn = 0; turn < 1; turn += 0.02)
    see(map, world, stamp += 0.1, {4.6 + std::sin(pi * turn), 1 - std::cos(pi * turn), pi * turn});
  for (double x = 4.6; x > 2; x -= 0.03) see(map, world, stamp += 0.1, {x, 2.0, pi});
  const Pose2 beside{3, 0, 0};
  const ObstaclePoints seen = map.obstacles(beside);
  Spread near, far;
  for (Eigen::Index i = 0; i < seen.points().rows(); ++i) {
    const double x = seen.points()(i, 0), y = seen.points()(i, 1);
    if (std::abs(x) > 0.8) continue;
    Spread& face = y < 1.009 ? near : far;
    const double error = y - (y < 1.009 ? 1.0 : 1.018);
    face.square += error * error;
    ++face.count;
  }
  EXPECT_GT(near.count, 40);
  EXPECT_GT(far.count, 40);
  EXPECT_LT(near.rms(), 0.006);
  EXPECT_LT(far.rms(), 0.006);
}

// A walker comes towards a chair that drives, on its left, and is out of its view when beside it.
int points_beside_after_meeting(double walking, double noise, int seed, double odometry_error = 0) {
  RollingMapConfig config = long_memory(noise);
  config.odometry_error = odometry_error;
  RollingMap map(config);
  ScannedWorld world{.walls = {{-3, -4, 20, -4}, {-3, 4, 20, 4}}, .posts = {{0, 0.8, 0.12}}, .noise = noise};
  world.rng.seed(seed);
  double last_seen = -1;
  for (int k = 0; last_seen < 0 || 0.1 * k < last_seen + 4; ++k) {
    const Pose2 base{0.05 * k, 0, 0};
    world.posts[0].x = 4.5 - walking * 0.1 * k;
    see(map, world, 0.1 * k, base);
    if (last_seen < 0 && world.posts[0].x < base.x + 0.5) last_seen = 0.1 * k;
  }
  const Pose2 base{0.05 * 10 * last_seen + 0.2, 0, 0};
  const ObstaclePoints seen = map.obstacles(base);
  int left = 0;
  for (const double y : seen.points().col(1)) left += std::abs(y - 0.8) < 0.3;
  return left;
}

// hazard: A person's last points stay | requirement:
// forgotten after a few seconds; what stands is kept | count: 1 case
TEST(RollingMap, a_person_who_walks_out_of_view_is_forgotten_after_a_few_seconds) {
  for (const double noise : {0.01, 0.03})
    for (const double walking : {0.3, 0.5, 1.4})
      for (const double error : {0.0, 0.02, 0.05})
        for (int seed = 0; seed < 3; ++seed)
          EXPECT_EQ(points_beside_after_meeting(walking, noise, seed, error), 0)
              << "at " << walking << " m/s, noise " << noise << ", odometry error " << error;
}

TEST(RollingMap, a_person_who_stands_there_is_kept) {
  for (int seed = 0; seed < 3; ++seed) EXPECT_GT(points_beside_after_meeting(0, 0.01, seed), 0);
}

TEST(RollingMap, who_walks_is_told_while_the_chair_turns) {
  for (const double error : {0.0, 0.02, 0.05}) {
    RollingMap map({.duration = 120, .odometry_error = error});
    ScannedWorld world{.walls = {{-9, -9, 9, -9}, {9, -9, 9, 9}, {9, 9, -9, 9}, {-9, 9, -9, -9}},
                       .posts = {{0, 0.8, 0.25}}};
    int told = 0;
    for (int k = 0; k < 30; ++k) {
      world.posts[0].x = 4.5 - 0.11 * k;
      const Pose2 base{0, 0, 0.5 * std::sin(0.2 * k)};
      see(map, world, 0.1 * k, base);
      told += distance_to(map.walkers(base), base.inverse() * Eigen::Vector2d(world.posts[0].x - 0.2, 0.7)) < 0.3;
    }
    EXPECT_GT(told, 15) << error;
  }
}

TEST(RollingMap, who_walks_is_told_apart_from_what_stands) {
  RollingMap map(long_memory(0.01));
  ScannedWorld world{.walls = {{-3, -4, 20, -4}, {-3, 4, 20, 4}}, .posts = {{0, 0.8, 0.12}, {2.5, -0.8, 0.12}}};
  for (int k = 0; k < 25; ++k) {
    world.posts[0].x = 4.5 - 0.11 * k;
    see(map, world, 0.1 * k, {});
    const ObstaclePoints walkers = map.walkers({});
    if (k >= 5) EXPECT_LT(distance_to(walkers, {world.posts[0].x - 0.1, 0.75}), 0.2) << k;
    for (const auto& point : walkers.points().rowwise()) EXPECT_NEAR(point.y(), 0.8, 0.3) << k;
  }
  for (int k = 25; k < 32; ++k) map.insert(0.1 * k, blind, mounting, {});
  EXPECT_EQ(map.walkers({}).points().rows(), 0);
}

// Stand beside the way: a pipe, a table's leg, a board's end, a box behind which the chair comes to look.
TEST(RollingMap, what_stands_is_kept_when_it_was_seen_in_passing) {
  for (const double noise : {0.01, 0.03})
    for (const double speed : {0.3, 0.6, 1.0})
      for (int seed = 0; seed < 3; ++seed) {
        RollingMap map(long_memory(noise));
        ScannedWorld world{.walls = {{-3, -4, 20, -4}, {-3, 4, 20, 4}},
                           .posts = {{3.0, 0.8, 0.01}, {3.4, -0.8, 0.02}, {3.8, 0.8, 0.03}},
                           .noise = noise};
        world.add_box(4.2, -0.80, 4.9, -0.782);
        world.add_box(4.4, 0.7, 4.8, 1.1);
        world.rng.seed(seed);
        double stamp = 0, x = 0;
        for (; x < 4.3; x += 0.1 * speed) see(map, world, stamp += 0.1, {x, 0, 0});
        for (int k = 0; k < 60; ++k) see(map, world, stamp += 0.1, {x, 0, 0});
        const ObstaclePoints seen = map.obstacles({x, 0, 0});
        for (const Eigen::Vector2d& place :
             std::vector<Eigen::Vector2d>{{2.99, 0.8}, {3.385, -0.787}, {3.77, 0.79}, {4.2, -0.79}, {4.4, 0.7}}) {
          const double distance =
              (seen.points().rowwise() - (place - Eigen::Vector2d(x, 0)).transpose()).rowwise().norm().minCoeff();
          EXPECT_LT(distance, 0.02 + noise) << place.transpose() << " noise " << noise << " speed " << speed;
        }
      }
}

LaserScan one_hit(const Pose2& T_odom_laser, double x, double y) {
  const double dx = x - T_odom_laser.x, dy = y - T_odom_laser.y;
  return {.ranges = {static_cast<float>(std::hypot(dx, dy))}, .angle_min = std::atan2(dy, dx) - T_odom_laser.yaw};
}

TEST(RollingMap, a_straight_drive_smears_a_point_along_the_way_and_not_sideways) {
  RollingMap map({.range_noise = 0.001, .odometry_error = 0.05});
  map.insert(0, one_hit(mounting, 1.5, 0.6), mounting, {});
  for (int k = 1; k <= 10; ++k) map.insert(k, blind, mounting, {0.2 * k, 0, 0});
  const Path told = map.obstacles({2, 0, 0}).points();
  ASSERT_EQ(told.rows(), 3);
  EXPECT_NEAR((told.col(1).array() - 0.6).abs().maxCoeff(), 0, 1e-6);
  EXPECT_NEAR(told.col(0).minCoeff(), -0.5 - 0.1, 1e-6);
  EXPECT_NEAR(told.col(0).maxCoeff(), -0.5 + 0.1, 1e-6);
}

// A mean of hits is as old as they are on average.
TEST(RollingMap, a_point_seen_on_a_drive_lags_behind_by_its_age_until_the_chair_stands) {
  RollingMap map({.range_noise = 0.003, .odometry_error = 0.05});
  const auto places = [&](const Pose2& base) { return map.obstacles(base).points().rows(); };
  Pose2 base;
  for (int k = 0; k <= 10; ++k) {
    base = {0.1 * k, 0, 0.02 * k};
    map.insert(k, one_hit(base * mounting, 3, 0.6), mounting, base);
    EXPECT_EQ(places(base) > 1, k > 0) << k;
    EXPECT_LT((map.obstacles(base).points().rowwise() - (base.inverse() * Eigen::Vector2d(3, 0.6)).transpose())
                  .rowwise()
                  .norm()
                  .maxCoeff(),
              0.05);
  }
  for (int k = 11; k < 50; ++k) map.insert(k, one_hit(base * mounting, 3, 0.6), mounting, base);
  EXPECT_EQ(places(base), 1);
  for (int k = 50; k < 60; ++k) map.insert(k, blind, mounting, base);
  EXPECT_EQ(places(base), 1);
}

// The true way is the odometry's with its lengths or turns off by the share; where the point is then, is told.
TEST(RollingMap, wrong_lengths_or_turns_leave_a_point_where_it_is) {
  std::mt19937 rng(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int drive = 0; drive < 200; ++drive) {
    const double share = 0.05, way_share = (drive % 2 ? 1 : -1) * share, turn_share = (drive % 4 > 1 ? 1 : -1) * share;
    RollingMap map({.radius = 8, .range_noise = 0.001, .odometry_error = share});
    const Eigen::Vector2d point(1.5 + uniform(rng), uniform(rng));
    map.insert(0, one_hit(mounting, point.x(), point.y()), mounting, {});
    Pose2 believed, truth;
    Twist2 twist;
    for (int k = 1; k <= 40; ++k) {
      if (k % 10 == 1) twist = {0.8 * uniform(rng), 0.8 * uniform(rng)};
      believed = integrate(believed, twist, 0.1);
      truth = integrate(truth, {twist.linear * (1 + way_share), twist.angular * (1 + turn_share)}, 0.1);
      map.insert(0.1 * k, blind, mounting, believed);
    }
    const Eigen::Vector2d real = truth.inverse() * point;
    const double off = (map.obstacles(believed).points().rowwise() - real.transpose()).rowwise().norm().minCoeff();
    const double moved = (believed.inverse() * point - real).norm();
    EXPECT_LT(off, 0.008 + 0.2 * moved) << "moved by " << moved;
  }
}

// hazard: The scanner sees the driver's own foot | requirement:
// it is no obstacle, and its beam says nothing | count: 1 case
TEST(RollingMap, hits_deep_inside_the_own_body_are_no_obstacles_and_their_beams_say_nothing) {
  RollingMap map({.range_noise = 0.001, .own_body = Footprint{}});
  const Pose2 rear_laser{-0.30, 0, 0};
  map.insert(0, one_hit(rear_laser, 1.5, 0), rear_laser, {});
  map.insert(1, one_hit(rear_laser, 0.76, 0), rear_laser, {});  // 0.04 m inside
  EXPECT_EQ(map.size(), 1u);
  map.insert(2, one_hit(rear_laser, 0.78, 0), rear_laser, {});  // 0.02 m inside
  EXPECT_EQ(map.size(), 2u);
  map.clear();
  map.insert(0, one_hit(rear_laser, 0.76, 0), rear_laser, {});
  EXPECT_TRUE((map.local_grid({}).data == unknown_cell).all());
}

// A post is seen, and leaves the view as the chair turns and slips: the odometry says more than it does, or less.
// hazard: A chair slips | requirement: what was seen is remembered where it may be | count: 48 drives
TEST(RollingMap, what_stands_is_kept_by_a_chair_that_slips) {
  const double share = 0.05;
  int seen_well = 0;
  for (const double slip : {-share, share})
    for (const double radius : {0.015, 0.03, 0.06})
      for (const double turning : {0.65, 1.0})
        for (int seed = 0; seed < 4; ++seed) {
          std::mt19937 rng(seed);
          std::uniform_real_distribution<double> uniform(0, 1);
          RollingMap map({.duration = 600, .odometry_error = share, .own_body = Footprint{}});
          ScannedWorld world{.walls = {{-6, -5, 6, -5}, {6, -5, 6, 5}, {6, 5, -6, 5}, {-6, 5, -6, -5}},
                             .posts = {{1.5 + uniform(rng), uniform(rng) - 0.5, radius}}};
          world.rng.seed(seed);
          const Eigen::Vector2d post(world.posts[0].x, world.posts[0].y);
          const Twist2 forth{-0.2 * uniform(rng), turning}, back{-0.1 * uniform(rng), -turning};
          Pose2 believed, truth;
          int hits = 0;
          for (int k = 0; k < 90; ++k) {
            const LaserScan scan = world.scan(truth * mounting);
            map.insert(0.1 * k, scan, mounting, believed);
            for (int i = 0; i < 181; ++i) {
              const Eigen::Vector2d end(scan.ranges[i] * std::cos(scan.angle(i)),
                                        scan.ranges[i] * std::sin(scan.angle(i)));
              hits += ((truth * mounting) * end - post).norm() < radius + 0.04;
            }
            const Twist2 twist = k < 10 ? forth : (k < 55 ? back : Twist2{});
            believed = integrate(believed, twist, 0.1);
            truth = integrate(truth, {twist.linear * (1 - slip), twist.angular * (1 - slip)}, 0.1);
          }
          const Eigen::Vector2d real = truth.inverse() * post, thought = believed.inverse() * post;
          if (hits < 10) continue;
          ++seen_well;
          EXPECT_LT(distance_to(map.obstacles(believed), real), radius + 0.04 + 0.25 * (thought - real).norm())
              << "slip " << slip << " radius " << radius << " turning " << turning << " seed " << seed;
        }
  EXPECT_GT(seen_well, 30);
}

// A box of 0.2 m, seen from the front and from both front corners: what lies behind its face is no crack between
// two beams.
TEST(RollingMap, the_far_side_of_what_is_thin_is_unseen) {
  RollingMap map({.own_body = Footprint{}});
  ScannedWorld world{.walls = {{9, -9, 9, 9}}};
  world.add_box(1.6, -0.1, 1.8, 0.1);
  double stamp = 0;
  for (double y = -1.5; y < 1.5; y += 0.05) see(map, world, stamp += 0.1, {0, y, 0});
  const ObstaclePoints unseen = map.unseen({0, 0, 0}, {}, 1.5);
  int behind = 0, elsewhere = 0;
  for (const auto& point : unseen.points().rowwise()) {
    if (std::abs(point.y()) > 0.3 || point.x() < 1) continue;
    ++(point.x() > 1.6 && point.x() < 1.9 && std::abs(point.y()) < 0.1 ? behind : elsewhere);
  }
  EXPECT_GE(behind, 3);
  EXPECT_EQ(elsewhere, 0);
}

bool swept(const ObstaclePoints& unseen, Pose2 base, const Twist2& twist, double duration) {
  for (double t = 0; t <= duration; t += 0.02) {
    if (unseen.collides(base, {})) return true;
    base = integrate(base, twist, 0.02);
  }
  return false;
}

TEST(RollingMap, a_chair_that_has_just_started_has_not_seen_beside_and_behind_itself) {
  RollingMap map({.own_body = Footprint{}});
  EXPECT_TRUE(swept(map.unseen({}, {}, 1), {}, {0.5, 0}, 1));  // nothing is known yet
  ScannedWorld world{.walls = {{9, -9, 9, 9}}};
  see(map, world, 0, {});
  const ObstaclePoints unseen = map.unseen({}, {}, 1);
  EXPECT_FALSE(swept(unseen, {}, {1, 0}, 1));
  EXPECT_TRUE(swept(unseen, {}, {0, 1}, 0.5));
  EXPECT_TRUE(swept(unseen, {}, {0, -1}, 0.5));
  EXPECT_TRUE(swept(unseen, {}, {-0.3, 0}, 0.5));
}

// A chair of 5 % odometry error backs along the way that it came; what it saw there a while ago no longer counts.
TEST(RollingMap, what_was_seen_counts_until_odometry_may_be_wrong_by_a_tenth_of_a_metre) {
  for (const double error : {0.0, 0.05}) {
    RollingMap map({.odometry_error = error, .own_body = Footprint{}});
    ScannedWorld world{.walls = {{9, -9, 9, 9}}};
    double stamp = 0, x = 0;
    for (; x < 1.9; x += 0.05) see(map, world, stamp += 0.1, {x, 0, 0});
    EXPECT_FALSE(swept(map.unseen({x, 0, 0}, {}, 1), {}, {-0.5, 0}, 1));
    for (; x < 3; x += 0.05) see(map, world, stamp += 0.1, {x, 0, 0});
    for (; x > 1; x -= 0.05) see(map, world, stamp += 0.1, {x, 0, 0});
    EXPECT_EQ(swept(map.unseen({x, 0, 0}, {}, 1), {}, {-0.5, 0}, 1), error > 0);
  }
}

TEST(RollingMap, what_was_under_the_body_when_it_turned_on_the_spot_is_seen) {
  RollingMap map({.own_body = Footprint{}});
  ScannedWorld world{.walls = {{9, -9, 9, 9}}};
  double stamp = 0;
  for (int k = 0; k <= 63; ++k) see(map, world, stamp += 0.1, {0, 0, 0.1 * k});
  EXPECT_FALSE(swept(map.unseen({}, {}, 1), {}, {0, 1}, 6.3));
}

// With 1 and 9 degrees between beams, a tenth of them dropped, beside a wall, at 5 Hz.
TEST(RollingMap, ordinary_forward_driving_never_sweeps_over_unseen_space) {
  for (const int beams : {181, 21})
    for (const double turning : {0.0, 0.4, -0.7}) {
      RollingMap map({.duration = 120, .own_body = Footprint{}});
      ScannedWorld world{.walls = {{-3, 2.5, 30, 2.5}, {-3, -30, -3, 2.5}}, .dropped = 0.1, .beams = beams};
      Pose2 base;
      for (int k = 0; k < 60; ++k) {
        see(map, world, 0.2 * k, base);
        const Twist2 twist{0.8, base.x < 1.5 ? 0 : turning * std::sin(0.2 * k)};
        EXPECT_FALSE(swept(map.unseen(base, {}, 1), base.inverse() * base, twist, 0.8))
            << beams << " beams, turning " << turning << " at scan " << k;
        base = integrate(base, twist, 0.2);
      }
    }
}

}  // namespace
}  // namespace lfdcore
