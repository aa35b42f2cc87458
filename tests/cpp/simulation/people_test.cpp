#include "lfdcore/simulation/people.hpp"

#include <gtest/gtest.h>

#include <random>

namespace lfdcore {
namespace {

constexpr float none = std::numeric_limits<float>::infinity();

std::vector<Eigen::Vector2d> all_around(int beams) {
  std::vector<Eigen::Vector2d> made;
  for (int beam = 0; beam < beams; ++beam) made.push_back(beam_direction(2 * pi * beam / beams));
  return made;
}

/// The first of many points along the beam that lies in the disc.
double marched(const Pose2& laser, const Eigen::Vector2d& along, const Person& person, double range_max) {
  for (double t = 0; t <= range_max; t += 1e-3)
    if ((laser * Eigen::Vector2d(along * t) - person.position).norm() <= person.radius) return t;
  return none;
}

TEST(People, a_beam_ends_where_marching_along_it_first_meets_a_disc) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-4, 4), size(0.05, 0.8), angle(-pi, pi);
  const auto directions = all_around(90);
  for (int draw = 0; draw < 20; ++draw) {
    const Pose2 laser{place(random), place(random), angle(random)};
    std::vector<Person> people(4);
    for (Person& person : people) person = {{place(random), place(random)}, {0, 0}, size(random)};
    std::vector<float> ranges(directions.size(), none);
    std::vector<int> met(directions.size(), -1);
    cast_at_people(laser, directions, 5, people, ranges, met);
    for (std::size_t beam = 0; beam < directions.size(); ++beam) {
      double expected = none;
      for (const Person& person : people) expected = std::min(expected, marched(laser, directions[beam], person, 5));
      if (std::isfinite(expected)) EXPECT_NEAR(ranges[beam], expected, 1.1e-3);
      if (met[beam] < 0) continue;
      const Person& person = people[met[beam]];  // whose edge is where the beam ends, or the laser is in it
      const double from_centre = (laser * Eigen::Vector2d(directions[beam] * ranges[beam]) - person.position).norm();
      if (ranges[beam] > 0) EXPECT_NEAR(from_centre, person.radius, 1e-6);
      EXPECT_LE(from_centre, person.radius + 1e-6);
    }
  }
}

TEST(People, no_range_grows_and_what_stands_behind_is_not_met) {
  const auto ahead = all_around(1);
  std::vector<float> ranges{2};
  std::vector<int> met{-1};
  cast_at_people({}, ahead, 10, std::vector<Person>{{{5, 0}, {0, 0}, 0.25}}, ranges, met);
  EXPECT_EQ(ranges[0], 2);
  EXPECT_EQ(met[0], -1);
  cast_at_people({}, ahead, 10, std::vector<Person>{{{-1, 0}, {0, 0}, 0.25}}, ranges, met);
  EXPECT_EQ(ranges[0], 2);
}

TEST(People, a_laser_in_a_disc_measures_nothing_but_it) {
  std::vector<float> ranges(16, 3.0f);
  cast_at_people({1, 2, 0.5}, all_around(16), 10, std::vector<Person>{{{1.1, 2.1}, {0, 0}, 0.25}}, ranges);
  EXPECT_EQ(ranges, std::vector<float>(16, 0.0f));
}

TEST(People, a_disc_is_met_at_range_max_and_not_beyond) {
  const auto ahead = all_around(1);
  std::vector<float> ranges{none};
  cast_at_people({}, ahead, 4, std::vector<Person>{{{4.2500001, 0}, {0, 0}, 0.25}}, ranges);
  EXPECT_EQ(ranges[0], none);
  cast_at_people({}, ahead, 4, std::vector<Person>{{{4.25, 0}, {0, 0}, 0.25}}, ranges);
  EXPECT_EQ(ranges[0], 4);
}

TEST(People, a_person_out_of_range_is_refused_by_name) {
  EXPECT_THROW(validate(Person{{0, 0}, {0, 0}, 0}), std::invalid_argument);
  EXPECT_THROW(validate(Person{{0, NAN}, {0, 0}, 0.25}), std::invalid_argument);
  EXPECT_THROW(validate(Person{{0, 0}, {11, 0}, 0.25}), std::invalid_argument);
}

}  // namespace
}  // namespace lfdcore
