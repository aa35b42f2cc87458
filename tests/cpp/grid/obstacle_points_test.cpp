#include "lfdcore/grid/obstacle_points.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace lfdcore {
namespace {

// The oracle: every point, by the definition of the distance to a rectangle.
double clearance_by_looking_at_every_point(const Path& points, const Pose2& pose, const Footprint& f) {
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  double nearest = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const double dx = points(i, 0) - pose.x, dy = points(i, 1) - pose.y;
    const double x = c * dx + s * dy, y = -s * dx + c * dy;
    const double beyond = std::max({x - f.front, -f.rear - x, 0.0});
    const double beside = std::max(std::abs(y) - f.half_width, 0.0);
    nearest = std::min(nearest, beyond * beyond + beside * beside);
  }
  return std::sqrt(nearest);
}

Path random_points(std::mt19937& random, int count, double extent, double offset) {
  std::uniform_real_distribution<double> at(-extent, extent);
  Path points(count, 2);
  for (int i = 0; i < count; ++i) points.row(i) << at(random) + offset, at(random) - offset;
  return points;
}

struct Cloud {
  int count;
  double extent, offset;  // [m]
  Footprint footprint;
};

class ObstaclePointsIn : public testing::TestWithParam<Cloud> {};

TEST_P(ObstaclePointsIn, a_cloud_answer_as_a_loop_over_all_points) {
  const auto& [count, extent, offset, footprint] = GetParam();
  std::mt19937 random(7);
  const Path points = random_points(random, count, extent, offset);
  const ObstaclePoints obstacles(points);
  std::uniform_real_distribution<double> at(-1.5 * extent, 1.5 * extent), yaw(-pi, pi);
  for (int i = 0; i < 2000; ++i) {
    const Pose2 pose{at(random) + offset, at(random) - offset, yaw(random)};
    const double expected = clearance_by_looking_at_every_point(points, pose, footprint);
    ASSERT_EQ(obstacles.clearance(pose, footprint), expected);
    ASSERT_EQ(obstacles.collides(pose, footprint), expected <= 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, ObstaclePointsIn,
                         testing::Values(Cloud{1, 1, 0, {}}, Cloud{60, 4, 0, {}}, Cloud{800, 4, 0, {}},
                                         Cloud{300, 30, 0, {}}, Cloud{60, 4, 1e6, {}}, Cloud{40, 1e5, 0, {}},
                                         Cloud{60, 4, 0, Footprint{0, 0, 0}}, Cloud{60, 4, 0, Footprint{3, 1, 2}},
                                         Cloud{60, 4, 0, Footprint{0.2, 0.2, 1.5}}));

TEST(ObstaclePoints, on_the_footprints_edge_collide) {
  Path points(1, 2);
  points << 0.80, 0.35;
  EXPECT_TRUE(ObstaclePoints(points).collides({}, {}));
  EXPECT_FALSE(ObstaclePoints(points).collides({-1e-9, 0, 0}, {}));
}

TEST(ObstaclePoints, around_a_hair_of_the_edge_answer_as_a_loop_over_all_points) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> hair(-1e-12, 1e-12), yaw(-pi, pi);
  const Footprint footprint;
  for (int i = 0; i < 2000; ++i) {
    const Pose2 pose{0.3, -0.2, yaw(random)};
    Path points(1, 2);
    points.row(0) = (pose * (footprint.corners()[i % 4] * (1 + hair(random)))).transpose();
    const bool expected = clearance_by_looking_at_every_point(points, pose, footprint) <= 0;
    ASSERT_EQ(ObstaclePoints(points).collides(pose, footprint), expected);
  }
}

TEST(ObstaclePoints, without_points_never_collide) {
  EXPECT_FALSE(ObstaclePoints().collides({}, {}));
  EXPECT_EQ(ObstaclePoints(Path(0, 2)).clearance({}, {}), std::numeric_limits<double>::infinity());
}

TEST(ObstaclePoints, that_coincide_are_one_obstacle) {
  const Path points = Path::Constant(1000, 2, 2.0);
  EXPECT_DOUBLE_EQ(ObstaclePoints(points).clearance({0, 2, 0}, {}), 1.2);
}

TEST(ObstaclePoints, hold_an_uncertainty_a_point_that_moves_no_answer) {
  const Path points = Path::Constant(2, 2, 2.0);
  EXPECT_EQ(ObstaclePoints(points).uncertainty(), std::vector<double>(2, 0.0));
  EXPECT_EQ(ObstaclePoints().uncertainty(), std::vector<double>());
  const ObstaclePoints unsure(points, {0.1, 0.3});
  EXPECT_EQ(unsure.uncertainty(), (std::vector<double>{0.1, 0.3}));
  EXPECT_EQ(unsure.clearance({0, 2, 0}, {}), ObstaclePoints(points).clearance({0, 2, 0}, {}));
}

TEST(ObstaclePoints, refuse_uncertainties_out_of_bounds_or_number) {
  const Path points = Path::Constant(2, 2, 2.0);
  EXPECT_THROW(ObstaclePoints(points, {0.1}), std::invalid_argument);
  EXPECT_THROW(ObstaclePoints(points, {0.1, -0.1}), std::invalid_argument);
  EXPECT_THROW(ObstaclePoints(points, {0.1, NAN}), std::invalid_argument);
  EXPECT_THROW(ObstaclePoints(points, {0.1, 101}), std::invalid_argument);
}

TEST(ObstaclePoints, refuse_what_is_not_finite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(ObstaclePoints(Path::Constant(1, 2, nan)), std::invalid_argument);
  EXPECT_THROW(ObstaclePoints().collides({nan, 0, 0}, {}), std::invalid_argument);
  EXPECT_THROW(ObstaclePoints().clearance({0, 0, nan}, {}), std::invalid_argument);
  EXPECT_THROW(ObstaclePoints().clearance({}, {nan, 0.3, 0.3}), std::invalid_argument);
}

}  // namespace
}  // namespace lfdcore
