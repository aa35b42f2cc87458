#include "lfdcore/simulation/person_contact.hpp"

#include <gtest/gtest.h>

#include <random>

namespace lfdcore {
namespace {

constexpr double period = 0.02;

std::vector<PersonContact> met_at_once(const Pose2& pose, const Twist2& twist, const Person& person) {
  PersonContacts contacts;
  contacts.note(0, pose, twist, {}, std::vector<Person>{person}, period);
  return contacts.all();
}

/// Distance of a point from the outline's rectangle, by its points a centimetre apart.
double apart(const Pose2& pose, const Footprint& body, const Eigen::Vector2d& point) {
  double least = 1e9;
  for (double x = -body.rear; x <= body.front + 1e-9; x += 0.01)
    for (double y = -body.half_width; y <= body.half_width + 1e-9; y += 0.01)
      least = std::min(least, (pose * Eigen::Vector2d(x, y) - point).norm());
  return least;
}

TEST(PersonContacts, a_disc_is_met_exactly_if_it_reaches_a_point_of_the_body) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> place(-1.6, 1.6), angle(-pi, pi);
  int met = 0;
  for (int draw = 0; draw < 400; ++draw) {
    const Pose2 pose{place(random), place(random), angle(random)};
    const Person person{{place(random), place(random)}, {0, 0}, 0.25};
    const double distance = apart(pose, {}, person.position);
    if (std::abs(distance - person.radius) < 0.01) continue;
    EXPECT_EQ(met_at_once(pose, {}, person).size(), distance < person.radius);
    met += distance < person.radius;
  }
  EXPECT_GT(met, 50);
}

TEST(PersonContacts, the_approaches_add_up_to_how_fast_the_gap_closes) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  const Footprint body;
  for (int draw = 0; draw < 200; ++draw) {
    const Pose2 pose{unit(random), unit(random), pi * unit(random)};
    const Eigen::Vector2d on_nose(body.front + 0.2, 0.3 * unit(random));
    const Person person{pose * on_nose, {unit(random), unit(random)}, 0.25};
    const Twist2 twist{unit(random), unit(random)};
    const PersonContact contact = met_at_once(pose, twist, person).at(0);
    constexpr double brief = 1e-6;
    const double before = apart(pose, body, person.position);
    const Eigen::Vector2d later = integrate(pose, twist, brief).inverse() * (person.position + person.velocity * brief);
    const double after = later.x() - body.front;
    EXPECT_NEAR((0.2 - after) / brief, contact.chair_approach + contact.person_approach, 1e-4);
    EXPECT_NEAR(before, 0.2, 1e-3);
  }
}

TEST(PersonContacts, the_part_is_where_the_outline_is_nearest) {
  const auto part = [](double x, double y) { return met_at_once({}, {}, {{x, y}, {0, 0}, 0.25}).at(0).part; };
  EXPECT_EQ(part(1.0, 0.1), OutlinePart::nose);
  EXPECT_EQ(part(0.9, 0.45), OutlinePart::nose);  // a corner
  EXPECT_EQ(part(0.5, 0.5), OutlinePart::left);
  EXPECT_EQ(part(0.0, -0.5), OutlinePart::right);
  EXPECT_EQ(part(-0.5, 0.0), OutlinePart::rear);
  EXPECT_EQ(part(0.7, 0.0), OutlinePart::nose);  // inside, nearest to the nose
  EXPECT_EQ(part(0.2, -0.3), OutlinePart::right);
}

TEST(PersonContacts, who_comes_is_told_apart) {
  const auto driven_into = met_at_once({}, {0.6, 0}, {{1.0, 0}, {0, 0}, 0.25}).at(0);
  EXPECT_DOUBLE_EQ(driven_into.chair_approach, 0.6);
  EXPECT_DOUBLE_EQ(driven_into.person_approach, 0);
  const auto walked_into = met_at_once({0, 0, pi / 2}, {}, {{0, 1.0}, {0, -1.2}, 0.25}).at(0);
  EXPECT_DOUBLE_EQ(walked_into.chair_approach, 0);
  EXPECT_NEAR(walked_into.person_approach, 1.2, 1e-12);
  const auto from_the_side = met_at_once({}, {0.6, 0}, {{0.3, 0.5}, {0, -1.0}, 0.25}).at(0);
  EXPECT_DOUBLE_EQ(from_the_side.chair_approach, 0);
  const auto swung_at = met_at_once({}, {0, 0.5}, {{0.6, 0.5}, {0, 0}, 0.25}).at(0);
  EXPECT_DOUBLE_EQ(swung_at.chair_approach, 0.3);
}

TEST(PersonContacts, a_contact_that_chatters_counts_once_and_one_after_the_release_again) {
  PersonContacts contacts;
  const auto stand = [&contacts](double gap, int periods) {
    const std::vector<Person> people{{{0.8 + 0.25 + gap, 0}, {0, 0}, 0.25}};
    for (int i = 0; i < periods; ++i) contacts.note(0, {}, {}, {}, people, period);
  };
  stand(0.01, 10);
  EXPECT_EQ(contacts.all().size(), 0u);
  for (int i = 0; i < 5; ++i) {
    stand(-0.01, 3);
    stand(0.03, 20);  // .4 s
  }
  EXPECT_EQ(contacts.all().size(), 1u);
  EXPECT_TRUE(contacts.touching());
  stand(0.03, 25);
  EXPECT_FALSE(contacts.touching());
  stand(0, 1);
  EXPECT_EQ(contacts.all().size(), 2u);
}

TEST(PersonContacts, a_chair_that_drives_on_into_one_it_touches_is_noted) {
  PersonContacts contacts;
  contacts.note(0, {}, {}, {}, std::vector<Person>{{{1.0, 0}, {-1, 0}, 0.25}}, period);
  contacts.note(1, {}, {0.4, 0}, {}, std::vector<Person>{{{0.9, 0}, {0, 0}, 0.25}}, period);
  contacts.note(2, {}, {0.9, 0}, {}, std::vector<Person>{{{0.7, 0}, {0, 0}, 0.25}}, period);  // its centre is inside
  ASSERT_EQ(contacts.all().size(), 1u);
  EXPECT_DOUBLE_EQ(contacts.all()[0].chair_approach, 0);
  EXPECT_DOUBLE_EQ(contacts.all()[0].chair_approach_since, 0.4);
}

}  // namespace
}  // namespace lfdcore
