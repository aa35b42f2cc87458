// A chair whose sides, nose or inside something touches: it gets on, and nothing gets deeper.
#include <gtest/gtest.h>

#include <random>

#include "lfdcore/control/supervisor.hpp"

namespace lfdcore {
namespace {

using Random = std::mt19937_64;
using Points = std::vector<Eigen::Vector2d>;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double degree = pi / 180;
const Footprint body;

Path path_of(const Points& points) {
  Path path(static_cast<Eigen::Index>(points.size()), 2);
  for (std::size_t i = 0; i < points.size(); ++i) path.row(static_cast<Eigen::Index>(i)) = points[i].transpose();
  return path;
}

Points operator+(Points one, const Points& other) {
  one.insert(one.end(), other.begin(), other.end());
  return one;
}

// To the right of the chair: `beside` its side at the front, nearer by the angle [rad] ahead of it.
Points wall_beside(double beside, double angle = 0, double from = -2.35, double to = 10) {
  Points wall;
  for (double ahead = from; ahead < to; ahead += 0.03)
    wall.emplace_back(ahead, -body.half_width - beside + std::tan(angle) * (ahead - body.front));
  return wall;
}

Points mirrored(Points points) {
  for (Eigen::Vector2d& point : points) point.y() = -point.y();
  return points;
}

Points wall_across(double x, double half_length = 2) {
  Points wall;
  for (double y = -half_length; y < half_length; y += 0.03) wall.emplace_back(x, y);
  return wall;
}

// How points are seen: with an uncertainty of 3 standard deviations of their noise, drawn once or in each tick.
struct Sight {
  double uncertainty = 0;
  bool fresh = false;
  unsigned seed = 1;
  double turn_error = 0;  // [rad/s] by which odometry is wrong
};

// A chair in front of walls, where it was put at rest at the origin.
class Drive {
 public:
  Drive(const Points& walls, const Sight& sight)
      : walls_(walls), sight_(sight), errors_(walls.size()), random_(sight.seed) {
    draw_errors();
  }

  void hold(const Twist2& stick, int ticks) {
    for (int i = 0; i < ticks; ++i) {
      go(supervisor_.filter(stick, {twist.linear, twist.angular + sight_.turn_error}, seen()).twist);
      if (sight_.fresh) draw_errors();
    }
  }

  // The least signed distance [m] from the outline to what stands, now.
  double distance() const {
    double least = infinity;
    for (const Eigen::Vector2d& point : walls_) {
      const Eigen::Vector2d at = pose.inverse() * point;
      least = std::min(least, signed_distance(at.x(), at.y(), body));
    }
    return least;
  }

  Pose2 pose;
  Twist2 twist;
  double least = infinity;  // distance() while it moved

 private:
  void draw_errors() {
    for (Eigen::Vector2d& error : errors_)
      error = sight_.uncertainty / 3 * Eigen::Vector2d(normal_(random_), normal_(random_));
  }

  ObstaclePoints seen() const {
    Points points;
    for (std::size_t i = 0; i < walls_.size(); ++i) {
      const Eigen::Vector2d at = pose.inverse() * (walls_[i] + errors_[i]);
      if (at.norm() < 3) points.push_back(at);
    }
    return ObstaclePoints(path_of(points), std::vector<double>(points.size(), sight_.uncertainty));
  }

  void go(const Twist2& command) {
    const Pose2 before = pose;
    for (int i = 0; i < 10; ++i) {
      const Twist2 next = approach(twist, command, {}, 0.01);
      pose = integrate(pose, {(twist.linear + next.linear) / 2, (twist.angular + next.angular) / 2}, 0.01);
      twist = next;
    }
    if (before.x != pose.x || before.y != pose.y || before.yaw != pose.yaw) least = std::min(least, distance());
  }

  Points walls_;
  Sight sight_;
  Points errors_;
  Random random_;
  std::normal_distribution<double> normal_;
  Supervisor supervisor_;
};

std::vector<Sight> sights(unsigned seeds) {
  std::vector<Sight> all{{0, false, 1}};
  for (const double uncertainty : {0.003, 0.01})
    for (unsigned seed = 1; seed <= seeds; ++seed)
      for (const bool fresh : {false, true}) all.push_back({uncertainty, fresh, seed});
  return all;
}

std::string name(const Sight& sight, double beside) {
  return "uncertainty " + std::to_string(sight.uncertainty) + (sight.fresh ? " fresh" : " fixed") + " seed " +
         std::to_string(sight.seed) + " beside " + std::to_string(beside);
}

constexpr double touches[] = {0.015, 0.008, 0.005, 0.003, 0, -0.002, -0.005, -0.008};

// hazard: The chair is frozen | requirement: it creeps along a wall that touches its whole side, measured up to 8 mm
// inside, with noise of 0 to 3.3 mm | count: 272 drives
TEST(SupervisorTouch, a_wall_along_the_whole_side_is_crept_along_ahead_and_back) {
  for (const Sight& sight : sights(4))
    for (const double beside : touches)
      for (const double linear : {0.1, -0.15}) {
        Drive drive(wall_beside(beside, 0, -3, 3), sight);
        drive.hold({linear, 0}, 100);
        EXPECT_GT(drive.pose.x * linear / std::abs(linear), 0.95) << name(sight, beside) << " " << linear;
        EXPECT_EQ(drive.pose.yaw, 0);
      }
}

TEST(SupervisorTouch, so_are_walls_on_both_sides) {
  for (const Sight& sight : sights(3)) {
    Drive drive(wall_beside(-0.002) + mirrored(wall_beside(-0.006)), sight);
    drive.hold({0.6, 0.3}, 100);
    EXPECT_GT(drive.pose.x, 0.95) << name(sight, -0.002);
  }
}

TEST(SupervisorTouch, so_is_a_wall_with_a_doorway_in_it) {
  for (const Sight& sight : sights(3)) {
    Drive drive(wall_beside(-0.002, 0, -3, -0.1) + wall_beside(-0.002, 0, 0.65, 4), sight);
    drive.hold({0.6, 0}, 100);
    EXPECT_GT(drive.pose.x, 0.95) << name(sight, -0.002);
  }
}

// hazard: The chair is frozen | requirement: pieces of a wall that touch one side forbid one way at most
// | count: 300 random walls
TEST(SupervisorTouch, pieces_of_a_wall_forbid_one_way_at_most) {
  Random random(5);
  std::uniform_real_distribution<double> at(-1.2, 1.6), length(0, 0.6), depth(-0.009, 0.004);
  int forbidden = 0;
  for (int trial = 0; trial < 300; ++trial) {
    Points walls;
    const double beside = depth(random);
    for (int piece = 0; piece < 4; ++piece) {
      const double from = at(random);
      walls = walls + wall_beside(beside, 0, from, from + length(random));
    }
    double moved = infinity;
    for (const double linear : {0.1, -0.1}) {
      Drive drive(walls, {});
      drive.hold({linear, 0}, 5);
      forbidden += drive.pose.x == 0;
      moved = std::min(moved, linear > 0 ? -drive.pose.x : drive.pose.x);
    }
    EXPECT_LT(moved, -0.02) << trial << " beside " << beside;
  }
  EXPECT_GT(forbidden, 20);
}

TEST(SupervisorTouch, it_turns_away_from_a_wall_only_where_no_rear_corner_is_swung_into_it) {
  for (const double beside : {0.008, 0.003, 0.0}) {
    Drive along(wall_beside(beside), {}), before(wall_beside(beside, 0, 0.2), {});
    along.hold({0, 0.6}, 30);
    before.hold({0, 0.6}, 30);
    EXPECT_GE(along.least, beside - 1e-6);
    EXPECT_EQ(along.pose.yaw, 0);
    EXPECT_GE(before.least, beside - 1e-6);
    EXPECT_GT(before.pose.yaw, 0.3);
  }
}

// hazard: The chair is frozen | requirement: it backs out of a wall at its nose, and of a corner | count: 68 drives
TEST(SupervisorTouch, it_backs_out_of_a_wall_at_the_nose_and_out_of_a_corner) {
  for (const Sight& sight : sights(4))
    for (const Points& beside : {Points{}, wall_beside(-0.003, 0, -2.35, 0.8)}) {
      const Points walls = wall_across(body.front - 0.004) + beside;
      Drive back(walls, sight), ahead(walls, sight);
      back.hold({-0.3, 0}, 50);
      ahead.hold({0.3, 0}, 50);
      EXPECT_LT(back.pose.x, -0.4) << name(sight, -0.004);
      EXPECT_EQ(ahead.pose.x, 0) << name(sight, -0.004);
    }
}

// hazard: The chair is pressed into a wall | requirement: of a wall that comes nearer by 3 degrees it uses up 3 mm at
// most, of a slighter one 4 mm and the uncertainty, for as long as the stick is held | count: 48 drives of 600 ticks
TEST(SupervisorTouch, a_wall_that_comes_nearer_is_not_scraped_deeper_however_long_the_stick_is_held) {
  for (const double inclination : {0.1, 0.3, 1.0, 3.0})
    for (const Sight& sight : sights(1))
      for (const double beside : {0.003, 0.0, -0.005, -0.008}) {
        if (!sight.fresh && sight.uncertainty > 0) continue;
        Drive drive(wall_beside(beside, inclination * degree), sight);
        drive.hold({0.1, 0}, 600);
        const double allowed = inclination == 3 ? 0.003 : 0.004 + sight.uncertainty;
        EXPECT_GT(drive.least, beside - allowed) << inclination << " degrees, " << name(sight, beside);
      }
}

// hazard: The chair is pressed into a wall | requirement: one that is clear of it is not led into it, for as long as
// the stick is held | count: 15 drives of 600 ticks
TEST(SupervisorTouch, a_chair_that_is_clear_is_not_led_into_a_wall_that_comes_nearer) {
  for (const double inclination : {0.1, 0.3, 0.5, 1.0, 3.0})
    for (const Sight& sight : {Sight{0, true}, Sight{0.003, true}, Sight{0.01, true}}) {
      Drive drive(wall_beside(0.013 + sight.uncertainty, inclination * degree), sight);
      drive.hold({0.1, 0}, 600);
      EXPECT_GT(drive.least, 0) << inclination << " degrees, " << name(sight, 0);
      EXPECT_GT(drive.pose.x, 0.03) << inclination << " degrees, " << name(sight, 0);
    }
}

TEST(SupervisorTouch, who_lets_the_stick_go_gets_on_beside_a_wall_that_came_nearer_meanwhile) {
  const Sight sight{0.003, true};
  Drive drive(wall_beside(0.003, 0.3 * degree), sight);
  drive.hold({0.1, 0}, 300);
  const double held = drive.pose.x;
  drive.hold({0.1, 0}, 100);
  EXPECT_LT(drive.pose.x, held + 0.1);
  drive.hold({}, 5);
  drive.hold({0.1, 0}, 100);
  EXPECT_GT(drive.pose.x, held + 0.3);
  for (int i = 0; i < 20; ++i) {
    drive.hold({}, 5);
    drive.hold({0.1, 0}, 100);
  }
  EXPECT_GT(drive.least, -0.02);  // SideContact::deepest, and what noise adds
}

TEST(SupervisorTouch, a_foot_inside_the_outline_does_not_let_the_chair_scrape_along_other_things) {
  const Points feet{{0.5, -0.25}, {0.3, -0.26}};
  for (const Sight& sight : sights(2)) {
    Drive drive(wall_beside(0.02, 0, -2, -0.1) + wall_beside(-0.006, 0, 1.0), sight);
    drive.hold({0.1, 0}, 200);
    const double alone = drive.pose.x;
    ASSERT_LT(alone, 0.2);
    Drive with_feet(wall_beside(0.02, 0, -2, -0.1) + wall_beside(-0.006, 0, 1.0) + feet, sight);
    with_feet.hold({0.1, 0}, 200);
    EXPECT_NEAR(with_feet.pose.x, alone, 0.02) << name(sight, 0);
  }
}

// hazard: The chair is frozen | requirement: odometry that is wrong by up to .02 rad/s stops it neither beside a wall
// nor between walls with a foot 10 cm inside the outline | count: 104 drives
TEST(SupervisorTouch, odometry_that_is_a_little_wrong_does_not_stop_it) {
  for (const double turn_error : {-0.02, -0.005, 0.005, 0.02})
    for (const double linear : {0.3, -0.3}) {
      for (const double uncertainty : {0.0, 0.003, 0.01})
        for (const double beside : {0.02, 0.01, 0.005, 0.0}) {
          const Sight sight{uncertainty, false, 1, turn_error};
          Drive drive(wall_beside(beside, 0, -3, 3), sight);
          drive.hold({linear, 0}, 100);
          EXPECT_GT(std::abs(drive.pose.x), 0.9) << name(sight, beside) << " " << turn_error << " " << linear;
        }
      const Points narrow = wall_beside(0.01) + mirrored(wall_beside(0.01));
      Drive foot(narrow + Points{{0.3, -0.25}}, {0, false, 1, turn_error});
      foot.hold({linear, 0}, 20);
      EXPECT_GT(std::abs(foot.pose.x), 0.1) << turn_error << " " << linear;
    }
}

}  // namespace
}  // namespace lfdcore
