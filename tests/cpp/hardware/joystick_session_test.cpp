// The PC's side of the link against the firmware's own logic, on a virtual clock. LFDCORE_LINK_SCHEDULES says how many
// schedules of a faulty link are run.
#include "lfdcore/hardware/joystick_session.hpp"

#include <cmath>
#include <limits>

#include "../count_from.hpp"
#include "firmware_bench.hpp"

namespace lfdcore {
namespace {

using namespace joystick;

constexpr double began = 5000.25;  // [s] of the host's clock when a Pair is made

// A chip and a PC with a line each way; the host's clock and the chip's tell the same.
struct Pair {
  Bench chip;
  JoystickSession pc;
  Line to_pc, to_chip;
  Random random{1};
  double wanted_forward = 0.5;
  bool assistant_silent = false;
  long passed = 0;  // [ms]

  double now() const { return began + passed * 1e-3; }

  void run(int ms) {
    for (int i = 0; i < ms; ++i) {
      chip.run(1);
      ++passed;
      if (chip.pins.now % 100 == 0 && !assistant_silent) pc.command(wanted_forward, 0, now());
      report();
      deliver();
      pc.watch(now());
    }
  }
  void report() {
    if (chip.pins.now % report_ms != 0) return;
    std::uint8_t wire[most_wire];
    to_pc.put(wire, chip.chip.report(chip.pins.now, wire), chip.pins.now, random);
  }
  void deliver() {
    for (; !to_pc.bytes.empty() && to_pc.bytes.front().due <= chip.pins.now; to_pc.bytes.pop_front()) {
      const std::vector<std::uint8_t> answer = pc.take(&to_pc.bytes.front().byte, 1, now());
      to_chip.put(answer.data(), answer.size(), chip.pins.now, random);
    }
    for (; !to_chip.bytes.empty() && to_chip.bytes.front().due <= chip.pins.now; to_chip.bytes.pop_front())
      chip.chip.take(to_chip.bytes.front().byte, chip.pins.now);
  }
  void set_off() {
    chip.stick(centre);
    run(400);
    chip.stick(ahead);
    run(200);
    ASSERT_EQ(pc.state(), State::driving);
    ASSERT_NEAR(chip.chip.given().forward, full / 2, 1);
  }
  bool stands() const { return is_zero(chip.chip.output()); }
};

TEST(JoystickSession, what_an_assistant_says_arrives_at_the_chair) {
  Pair pair;
  pair.set_off();
  const JoystickReading& said = pair.pc.newest().value();
  EXPECT_EQ(said.forward, 1);
  EXPECT_NEAR(said.given_forward, 0.5, 1e-3);
  EXPECT_NEAR(said.stamp, pair.now(), 0.011);
  EXPECT_EQ(pair.pc.statistics().lost_reports, 0);
  EXPECT_EQ(pair.pc.statistics().answers, pair.pc.statistics().reports);
}

TEST(JoystickSession, it_drives_on_when_the_chips_clock_wraps_around_after_49_days) {
  Pair pair;
  pair.chip.pins.now = 0xFFFFFFFF - 2000;
  pair.set_off();
  pair.run(3000);
  EXPECT_LT(pair.chip.pins.now, 3000u);
  EXPECT_NEAR(pair.pc.newest()->stamp, pair.now(), 0.011);
  EXPECT_EQ(pair.pc.state(), State::driving);
  EXPECT_FALSE(pair.stands());
}

TEST(JoystickSession, a_chip_that_was_reset_is_another_connection_and_another_run_however_quickly_it_is_back) {
  Pair pair;
  pair.set_off();
  const long run = pair.pc.newest()->run;
  pair.chip = Bench();
  pair.run(20);
  EXPECT_EQ(pair.pc.statistics().connections, 2);
  EXPECT_EQ(pair.pc.statistics().lost_reports, 0);
  EXPECT_EQ(pair.pc.newest()->run, run + 1);
  EXPECT_EQ(pair.pc.state(), State::neutral_required);
}

TEST(JoystickSession, a_chip_that_counted_on_behind_a_cut_cable_is_the_same_run) {
  Pair pair;
  pair.set_off();
  pair.pc.take_readings();
  pair.to_pc.cut = true;
  pair.run(700);
  EXPECT_TRUE(pair.pc.take_readings().empty());
  pair.to_pc.cut = false;
  pair.run(100);
  const std::vector<JoystickReading> readings = pair.pc.take_readings();
  EXPECT_EQ(readings.size(), 10u);
  EXPECT_EQ(readings.back().run, 0);
  EXPECT_EQ(pair.pc.statistics().connections, 2);
}

TEST(JoystickSession, readings_that_nobody_takes_are_those_of_two_seconds) {
  Pair pair;
  pair.run(5000);
  const std::vector<JoystickReading> readings = pair.pc.take_readings();
  EXPECT_EQ(readings.size(), 200u);
  EXPECT_EQ(readings.back().tick, pair.pc.newest()->tick);
}

TEST(JoystickSession, a_report_of_what_cannot_be_is_none) {
  const struct {
    std::size_t at;
    std::uint8_t byte;
  } changes[] = {{5, 0x7F}, {7, 0x7F}, {23, 0x7F}, {25, 0x80}, {26, 5}, {30, profiles}};
  Bench chip;
  chip.run(20);
  for (const auto& change : changes) {
    JoystickSession pc;
    std::uint8_t wire[most_wire], body[most_wire];
    const std::size_t count = chip.chip.report(chip.pins.now, wire);
    cobs_decode(wire, count - 1, body);
    EXPECT_FALSE(pc.take(wire, count, began).empty());
    body[header_bytes + change.at] = change.byte;
    const std::size_t sent = encode_frame(FrameType::report, 0, body + header_bytes, wire);
    EXPECT_TRUE(pc.take(wire, sent, began + 0.01).empty()) << change.at;
    EXPECT_EQ(pc.statistics().bad_frames, 1);
    EXPECT_EQ(pc.statistics().reports, 1);
  }
}

TEST(JoystickSession, a_stick_that_is_held_when_the_link_begins_moves_nothing_until_it_was_at_neutral) {
  Pair pair;
  pair.set_off();
  pair.pc = JoystickSession();  // the program was started again, the chip was not
  pair.run(2000);
  EXPECT_EQ(pair.pc.state(), State::neutral_required);
  EXPECT_TRUE(pair.stands());
  pair.set_off();
}

// hazard: The assistant falls silent | requirement: its command ends after 250 ms | count: 1 case
TEST(JoystickSession, a_silent_assistant_stops_the_chair_after_its_command_expires) {
  Pair pair;
  pair.set_off();
  pair.assistant_silent = true;
  const double last = pair.now();
  while (!pair.stands()) pair.run(1);
  EXPECT_LE(pair.now() - last, JoystickSession::expiry + 0.011);
  EXPECT_EQ(pair.pc.state(), State::ready);
}

TEST(JoystickSession, what_is_no_command_is_a_fault_until_neutral) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  for (const double wrong : {nan, infinity, 1.01, -1.01}) {
    Pair pair;
    pair.set_off();
    pair.wanted_forward = wrong;
    pair.run(110);
    EXPECT_EQ(pair.pc.state(), State::fault) << wrong;
    EXPECT_TRUE(pair.stands());
    pair.wanted_forward = 0.5;
    pair.run(500);
    EXPECT_EQ(pair.pc.state(), State::neutral_required);
    pair.set_off();
  }
}

TEST(JoystickSession, a_cut_cable_is_disconnected_and_back_needs_neutral) {
  Pair pair;
  pair.set_off();
  pair.to_pc.cut = pair.to_chip.cut = true;
  pair.run(112);
  EXPECT_EQ(pair.pc.state(), State::disconnected);
  EXPECT_FALSE(pair.pc.newest().has_value());
  EXPECT_TRUE(pair.stands());
  pair.to_pc.cut = pair.to_chip.cut = false;
  pair.run(500);
  EXPECT_EQ(pair.pc.state(), State::neutral_required);
  EXPECT_EQ(pair.pc.statistics().connections, 2);
  pair.set_off();
}

TEST(JoystickSession, a_report_that_comes_late_has_the_stamp_at_which_the_stick_was_read) {
  Pair pair;
  pair.set_off();
  pair.to_pc.delay = 80;
  pair.run(500);
  EXPECT_NEAR(pair.now() - pair.pc.newest()->stamp, 0.085, 0.012);
  EXPECT_LE(pair.pc.newest()->stamp, pair.now());
}

TEST(JoystickSession, a_chip_that_begins_anew_has_stamps_of_now) {
  Pair pair;
  pair.set_off();
  pair.chip = Bench();
  pair.run(300);
  EXPECT_LE(std::abs(pair.pc.newest()->stamp - pair.now()), 0.011);
  pair.set_off();
}

TEST(JoystickSession, another_profile_needs_neutral_on_both_sides) {
  Pair pair;
  pair.set_off();
  const std::vector<std::uint8_t> bytes = pair.pc.select_profile(2);
  for (const std::uint8_t byte : bytes) pair.chip.chip.take(byte, pair.chip.pins.now);
  pair.run(300);
  EXPECT_EQ(pair.pc.state(), State::neutral_required);
  EXPECT_TRUE(pair.stands());
  EXPECT_THROW(pair.pc.select_profile(profiles), std::invalid_argument);
}

TEST(JoystickSession, the_chip_says_who_it_is_and_takes_a_calibration) {
  Pair pair;
  pair.set_off();
  Calibration other = usual;
  other.axis[0].dead_zone = 33;
  pair.chip.stick(centre);
  pair.run(100);
  for (const std::uint8_t byte : pair.pc.set_calibration(other)) pair.chip.chip.take(byte, pair.chip.pins.now);
  std::uint8_t wire[most_wire];
  pair.to_pc.put(wire, pair.chip.chip.identity(wire), pair.chip.pins.now, pair.random);
  pair.run(10);
  EXPECT_EQ(pair.pc.identity().value().calibration.axis[0].dead_zone, 33);
  EXPECT_TRUE(pair.pc.identity()->calibrated);
  other.axis[0].centre = other.axis[0].plus;
  EXPECT_THROW(pair.pc.set_calibration(other), std::invalid_argument);
}

// All that can go wrong on the way, then nothing any more.
struct Outcome {
  bool moved_on_an_old_command = false, came_back = false;
};

Outcome run_schedule(long number) {
  Pair pair;
  pair.random.seed(static_cast<std::uint64_t>(number));
  Random& random = pair.random;
  pair.set_off();
  Outcome outcome;
  double said = pair.now();
  for (int spell = 0; spell < 8; ++spell) {
    const auto chance = [&](unsigned one_in) { return spell < 7 && random() % one_in == 0; };
    pair.to_pc.cut = chance(5), pair.to_chip.cut = chance(5), pair.assistant_silent = chance(5);
    pair.to_pc.garbage = chance(4), pair.to_chip.garbage = chance(4);
    pair.to_pc.delay = chance(3) ? static_cast<std::uint32_t>(random() % 300) : 0;
    pair.to_chip.delay = chance(3) ? static_cast<std::uint32_t>(random() % 300) : 0;
    pair.wanted_forward = chance(8) ? std::numeric_limits<double>::quiet_NaN() : 0.5;
    const int spell_ms = spell < 7 ? 20 + static_cast<int>(random() % 300) : 800;
    for (int ms = 0; ms < spell_ms; ++ms) {
      pair.run(1);
      if (!pair.assistant_silent && pair.chip.pins.now % 100 == 0) said = pair.now();
      if (pair.stands()) continue;
      const double line = (pair.to_pc.delay + pair.to_chip.delay) * 1e-3;
      const double limit = JoystickSession::expiry + command_ms * 1e-3 + 1e-3 * report_ms;
      outcome.moved_on_an_old_command |= pair.now() - said > limit + line;
    }
  }
  pair.set_off();
  outcome.came_back = pair.pc.state() == State::driving;
  return outcome;
}

// hazard: The link to the chair fails | requirement:
// cut, silent, delayed or garbled: nothing moves on an assistant's command that has expired by more than the chip's 100
// ms, and it drives again when all is well
// | count: 200 schedules of both sides on a virtual clock, LFDCORE_LINK_SCHEDULES
TEST(JoystickSession, whatever_the_line_does_an_expired_command_moves_nothing) {
  const long schedules = test::count_from("LFDCORE_LINK_SCHEDULES", 200);
  long late = 0;
  for (long n = 0; n < schedules; ++n) {
    const Outcome outcome = run_schedule(n);
    late += outcome.moved_on_an_old_command;
    ASSERT_TRUE(outcome.came_back) << n;
  }
  EXPECT_EQ(late, 0);
}

}  // namespace
}  // namespace lfdcore
