#include "lfdcore/control/side_contact.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace lfdcore {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double span = 0.575;

struct Point {
  double ahead, beside, uncertainty = 0;
};

void look_at(SideContact& side, const std::vector<Point>& points, bool may_touch = true) {
  side.look();
  for (const Point& point : points)
    if (SideContact::may_belong(point.beside, point.uncertainty)) side.add(point.ahead, point.beside);
  side.measure(span, may_touch);
}

std::vector<Point> wall(double beside, double slope = 0, double noise = 0, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<Point> points;
  for (double x = -0.35; x < 0.8; x += 0.03)
    points.push_back({x, beside + slope * (x - 0.8) + noise * normal(random), 3 * noise});
  return points;
}

// Pair by pair: as near as the farther one of two that lie half of the chair's length apart.
double level(const std::vector<Point>& points) {
  double least = infinity;
  for (const Point& one : points)
    for (const Point& other : points)
      if (one.ahead - other.ahead >= span) least = std::min(least, std::max(one.beside, other.beside));
  return least;
}

TEST(SideContact, agrees_with_comparing_all_pairs) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> ahead(-0.35, 0.8), beside(-0.0099, 0.0249);
  for (int trial = 0; trial < 500; ++trial) {
    std::vector<Point> points;
    for (int i = 0; i < trial % 12; ++i) points.push_back({ahead(random), beside(random)});
    SideContact side;
    look_at(side, points);
    const double expected = level(points);
    if (expected == infinity)
      EXPECT_EQ(side.least(0), infinity);
    else
      EXPECT_DOUBLE_EQ(side.least(0), expected - SideContact::roughness);
  }
}

TEST(SideContact, a_walls_next_point_may_be_nearer_by_its_uncertainty_as_far_as_that_counts) {
  SideContact side;
  look_at(side, wall(-0.004));
  EXPECT_NEAR(side.least(0), -0.005, 1e-12);
  EXPECT_NEAR(side.least(0.003), -0.008, 1e-12);
  EXPECT_NEAR(side.least(0.5), -0.015, 1e-12);
  side.let_go();
  look_at(side, wall(-0.015, 0, 0.004));
  EXPECT_NEAR(side.least(0), -SideContact::deepest - SideContact::roughness, 1e-12);
}

TEST(SideContact, neither_one_point_nor_a_corner_nor_what_is_too_deep_is_a_wall) {
  SideContact side;
  for (const auto& points : {std::vector<Point>{}, {{0.3, -0.005}}, {{0.3, 0}, {0.5, 0}, {0.8, 0}}, wall(-0.0101)}) {
    look_at(side, points);
    EXPECT_EQ(side.least(0.01), infinity);
  }
  look_at(side, wall(0, -0.05));  // 3 degrees
  EXPECT_EQ(side.least(0.01), infinity);
  look_at(side, wall(0), false);
  EXPECT_EQ(side.least(0.01), infinity);
}

TEST(SideContact, a_point_deep_inside_says_nothing_about_the_wall) {
  SideContact side;
  std::vector<Point> points = wall(0.002);
  points.push_back({0.8, -0.1});
  points.push_back({-0.2, -0.1});
  look_at(side, points);
  EXPECT_NEAR(side.least(0), 0.001, 1e-12);
}

TEST(SideContact, a_wall_that_comes_nearer_is_held_at_where_it_was_until_let_go_or_far) {
  SideContact side;
  look_at(side, wall(0.003));
  for (double beside = 0.003; beside > -0.008; beside -= 0.0002) look_at(side, wall(beside));
  EXPECT_NEAR(side.least(0), 0.002, 1e-12);
  side.let_go();
  look_at(side, wall(-0.004));
  EXPECT_NEAR(side.least(0), -0.005, 1e-12);
  look_at(side, wall(SideContact::near));
  look_at(side, wall(-0.006));
  EXPECT_NEAR(side.least(0), -0.007, 1e-12);
}

TEST(SideContact, no_noise_brings_what_is_held_lower_than_it_is_measured_once) {
  SideContact side;
  double highest = -infinity;
  for (unsigned tick = 0; tick < 300; ++tick) {
    const std::vector<Point> points = wall(0.002 - 1e-5 * tick, 0, 0.003, tick);
    highest = std::max(highest, level(points));
    look_at(side, points);
    ASSERT_DOUBLE_EQ(side.least(0), std::max(highest, -SideContact::deepest) - SideContact::roughness);
  }
}

}  // namespace
}  // namespace lfdcore
