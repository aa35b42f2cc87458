// The firmware's own logic, on a virtual clock: what docs/joystick-link.md promises. LFDCORE_LINK_SCHEDULES says how
// many schedules of a faulty link are run.
#include <algorithm>
#include <set>

#include "../count_from.hpp"
#include "firmware_bench.hpp"

namespace lfdcore {
namespace joystick {
namespace {

TEST(JoystickFirmware, drives_what_is_commanded_once_the_stick_was_at_neutral) {
  Bench bench;
  bench.stick(ahead);
  bench.run_answered(1000, {full / 2, 0});
  EXPECT_EQ(bench.chip.state(), State::neutral_required);
  EXPECT_TRUE(is_zero(bench.chip.output()));
  bench.set_off();
  EXPECT_EQ(bench.chip.output().code[0], (2048 + 3096) / 2);
  EXPECT_TRUE(bench.chip.output().enabled);
}

// hazard: The link to the chair fails | requirement: no answer for 100 ms: neutral | count: 1 case
TEST(JoystickFirmware, a_pc_that_falls_silent_leaves_neutral_after_100_ms_of_the_chips_clock) {
  Bench bench;
  bench.set_off();
  bench.run(100);
  EXPECT_FALSE(is_zero(bench.chip.output()));
  bench.run(11);  // the last answer was to the report before
  EXPECT_TRUE(is_zero(bench.chip.output()));
  EXPECT_EQ(bench.chip.state(), State::ready);
}

TEST(JoystickFirmware, a_frame_that_repeats_an_old_answer_keeps_nothing_going) {
  Bench bench;
  bench.set_off();
  const std::uint32_t tick = bench.pins.now - bench.pins.now % report_ms;
  for (int i = 0; i < 150; ++i) {
    bench.run(1);
    bench.command(tick, {full / 2, 0});
  }
  EXPECT_TRUE(is_zero(bench.chip.output()));
}

TEST(JoystickFirmware, an_answer_from_the_future_or_before_the_last_is_none) {
  Bench bench;
  bench.set_off();
  const Output before = bench.chip.output();
  bench.command(bench.pins.now + 5, {full, 0});
  bench.command(bench.pins.now - 60, {full, 0});
  EXPECT_EQ(bench.chip.output().code[0], before.code[0]);
}

TEST(JoystickFirmware, a_stick_let_go_stops_at_the_next_reading_whatever_is_commanded) {
  Bench bench;
  bench.set_off();
  bench.stick(centre);
  bench.run_answered(10, {full, full});
  EXPECT_TRUE(is_zero(bench.chip.output()));
}

TEST(JoystickFirmware, a_stick_pulled_against_the_motion_stops_it) {
  Bench bench;
  bench.set_off();
  bench.stick(back);
  bench.run_answered(10, {full / 2, 0});
  EXPECT_TRUE(is_zero(bench.chip.output()));
}

// hazard: The stick's wires break | requirement: neutral at once, a fault within 100 ms, ends at neutral only
// | count: 4 cases
TEST(JoystickFirmware, a_broken_or_short_wire_is_neutral_at_once_and_a_fault_within_100_ms) {
  for (const std::uint16_t count : {broken, adc_top})
    for (const int axis : {0, 1}) {
      Bench bench;
      bench.set_off();
      bench.pins.adc[axis] = count;
      bench.run_answered(10, {full / 2, 0});
      EXPECT_TRUE(is_zero(bench.chip.output()));
      bench.run_answered(90, {full / 2, 0});
      EXPECT_EQ(bench.chip.state(), State::fault);
      EXPECT_EQ(bench.chip.faults(), axis == 0 ? forward_wire : left_wire);
      bench.stick(ahead);
      bench.run_answered(500, {full / 2, 0});
      EXPECT_EQ(bench.chip.state(), State::neutral_required);
      bench.set_off();
    }
}

// hazard: The stick's wires break | requirement: what a broken wire can read is no end of a stick | count: 50 readings
TEST(JoystickFirmware, no_calibration_lets_a_broken_wire_or_a_lost_ground_look_like_a_stick) {
  for (const std::uint16_t minus : {51, 972}) {
    const std::uint16_t plus = minus == 51 ? 972 : 51;
    Calibration widest = usual;
    widest.axis[0] = {minus, 512, plus, 20};
    ASSERT_TRUE(is_sound(widest));
    for (std::uint16_t count = 0; count < 25; ++count) {
      EXPECT_FALSE(is_plausible(widest.axis[0], count));
      EXPECT_FALSE(is_plausible(widest.axis[0], adc_top - count));
    }
    widest.axis[0] = {static_cast<std::uint16_t>(minus == 51 ? 50 : 973), 512, plus, 20};
    EXPECT_FALSE(is_sound(widest));
  }
}

// hazard: The stick's wires break | requirement: one that is broken now and then is a fault | count: 3 rhythms
TEST(JoystickFirmware, a_wire_that_is_broken_now_and_then_is_a_fault) {
  for (const int whole : {10, 20, 30}) {
    Bench bench;
    bench.set_off();
    for (int i = 0; i < 25 && bench.chip.state() != State::fault; ++i) {
      bench.stick(broken);
      bench.run_answered(10, {full, 0});
      bench.stick(ahead);
      bench.run_answered(whole, {full, 0});
    }
    EXPECT_EQ(bench.chip.state(), State::fault) << whole;
  }
}

TEST(JoystickFirmware, after_a_fault_the_stick_must_be_at_neutral_for_as_long_as_ever) {
  Bench bench;
  bench.set_off();
  bench.stick(broken);
  bench.run_answered(100, {full, 0});
  bench.stick(centre);
  while (bench.chip.state() == State::fault) bench.run_answered(10, {full, 0});
  bench.run_answered(neutral_ms - 20, {full, 0});
  EXPECT_EQ(bench.chip.state(), State::neutral_required);
  bench.stick(ahead);
  bench.run_answered(1000, {full, 0});
  EXPECT_TRUE(is_zero(bench.chip.output()));
}

TEST(JoystickFirmware, a_command_out_of_range_is_a_fault_until_neutral) {
  Bench bench;
  bench.set_off();
  bench.command(bench.pins.now, {full + 1, 0});
  EXPECT_EQ(bench.chip.state(), State::fault);
  EXPECT_TRUE(is_zero(bench.chip.output()));
  bench.run_answered(300, {full / 2, 0});
  EXPECT_EQ(bench.chip.state(), State::neutral_required);
}

TEST(JoystickFirmware, the_emergency_input_opens_the_enable_line_until_neutral) {
  Bench bench;
  bench.set_off();
  bench.pins.emergency = true;
  bench.run_answered(10, {full / 2, 0});
  EXPECT_EQ(bench.chip.state(), State::emergency);
  EXPECT_FALSE(bench.chip.output().enabled);
  bench.pins.emergency = false;
  bench.run_answered(300, {full / 2, 0});
  EXPECT_EQ(bench.chip.state(), State::neutral_required);
}

TEST(JoystickFirmware, a_dac_that_does_not_answer_opens_the_enable_line) {
  Bench bench;
  bench.set_off();
  bench.chip.dac_answered(false);
  EXPECT_EQ(bench.chip.state(), State::fault);
  EXPECT_FALSE(bench.chip.output().enabled);
  bench.chip.dac_answered(true);
  EXPECT_EQ(bench.chip.state(), State::neutral_required);
  EXPECT_TRUE(bench.chip.output().enabled);
}

TEST(JoystickFirmware, another_profile_needs_neutral_and_gives_its_share) {
  Bench bench;
  bench.set_off();
  bench.select(1);
  EXPECT_EQ(bench.chip.state(), State::neutral_required);
  bench.run_answered(300, {full / 2, 0});
  EXPECT_TRUE(is_zero(bench.chip.output()));
  bench.stick(centre);
  bench.set_off();
  EXPECT_EQ(bench.chip.given().forward, full / 4);
  bench.select(profiles);
  EXPECT_EQ(bench.chip.state(), State::driving);
}

TEST(JoystickFirmware, without_a_calibration_nothing_is_enabled_until_it_gets_one) {
  Bench bench(nullptr);
  bench.run_answered(500, {full, 0});
  EXPECT_EQ(bench.chip.faults(), not_calibrated);
  EXPECT_FALSE(bench.chip.output().enabled);
  Calibration wrong = usual;
  wrong.axis[1].centre = wrong.axis[1].plus;
  bench.calibrate(wrong);
  EXPECT_EQ(bench.chip.faults(), not_calibrated);
  EXPECT_EQ(bench.chip.to_store(), nullptr);
  bench.calibrate(usual);
  EXPECT_NE(bench.chip.to_store(), nullptr);
  bench.set_off();
}

TEST(JoystickFirmware, is_not_calibrated_while_it_drives) {
  Bench bench;
  bench.set_off();
  Calibration other = usual;
  other.axis[0].dead_zone = 30;
  bench.calibrate(other);
  EXPECT_EQ(bench.chip.to_store(), nullptr);
  EXPECT_EQ(bench.chip.state(), State::driving);
}

TEST(JoystickFirmware, a_stick_says_the_same_whichever_way_it_is_wired) {
  for (int away = 0; away <= 312; ++away) {
    const auto up = static_cast<std::uint16_t>(centre + away), down = static_cast<std::uint16_t>(centre - away);
    EXPECT_EQ(stick_of(usual.axis[0], up), stick_of(usual.axis[1], down));
    EXPECT_EQ(stick_of(usual.axis[0], up), -stick_of(usual.axis[0], down));
    EXPECT_EQ(stick_of(usual.axis[0], up) == 0, away <= 20);
  }
  EXPECT_EQ(stick_of(usual.axis[0], ahead), full);
}

TEST(JoystickFirmware, what_the_stick_allows_keeps_its_laws) {
  Random random(1);
  std::uniform_int_distribution<int> any(-full, full);
  for (int n = 0; n < 200000; ++n) {
    const Axes wanted = {static_cast<std::int16_t>(any(random)), static_cast<std::int16_t>(any(random))};
    Axes stick = {static_cast<std::int16_t>(any(random)), static_cast<std::int16_t>(any(random))};
    if (random() % 4 == 0) stick.forward = 0;
    if (random() % 4 == 0) stick.left = 0;
    const Axes given = allowed(wanted, stick);
    const double out = std::hypot(stick.forward, stick.left);
    ASSERT_LE(std::abs(given.forward), out);
    ASSERT_LE(std::abs(given.left), out);
    ASSERT_GE(given.forward * stick.forward, 0);
    ASSERT_LE(std::abs(given.forward), std::abs(wanted.forward));
    ASSERT_LE(std::abs(given.left), std::abs(wanted.left));
    if (stick.forward == 0) {
      ASSERT_EQ(given.forward, 0);
      ASSERT_GE(given.left * stick.left, 0);
    }
  }
}

// The drawing in docs/joystick-link.md, one by one: what is not named leaves a state as it is.
TEST(LinkState, every_transition_is_the_one_that_is_drawn) {
  using S = State;
  using E = Event;
  const std::set<std::tuple<S, E, S>> drawn = {
      {S::neutral_required, E::stick_neutral, S::ready},
      {S::ready, E::command_fresh, S::driving},
      {S::driving, E::command_old, S::ready},
      {S::ready, E::settings_changed, S::neutral_required},
      {S::driving, E::settings_changed, S::neutral_required},
      {S::fault, E::fault_gone, S::neutral_required},
      {S::emergency, E::emergency_released, S::neutral_required},
      {S::disconnected, E::link_made, S::neutral_required},
  };
  for (int s = 0; s < states; ++s)
    for (int e = 0; e < events; ++e) {
      const auto state = static_cast<S>(s);
      const auto event = static_cast<E>(e);
      S wanted = state;
      for (const auto& [from, on, to] : drawn)
        if (from == state && on == event) wanted = to;
      if (event == E::link_lost) wanted = S::disconnected;
      if (state != S::disconnected && event == E::emergency_pressed) wanted = S::emergency;
      if (state != S::disconnected && state != S::emergency && event == E::fault_found) wanted = S::fault;
      EXPECT_EQ(next(state, event), wanted) << s << " " << e;
    }
}

// The states of a chip: all but `disconnected`, which is the PC's.
TEST(LinkState, every_state_of_the_chip_is_visited_by_what_can_happen_to_it) {
  Random random(2);
  std::set<State> visited;
  Bench bench;
  for (int n = 0; n < 20000; ++n) {
    if (random() % 50 == 0) bench.stick(random() % 3 == 0 ? ahead : random() % 5 == 0 ? broken : centre);
    if (random() % 100 == 0) bench.pins.emergency = random() % 4 == 0;
    if (random() % 2000 == 0) bench.select(static_cast<std::uint8_t>(random() % profiles));
    if (n % 500 < 400)
      bench.run_answered(10, {full / 2, 0});
    else
      bench.run(10);
    visited.insert(bench.chip.state());
  }
  EXPECT_EQ(visited.size(), 5u);
}

// A PC that answers every report that gets through, with what it is told to.
struct Answering {
  FrameReader reader;
  bool silent = false;
  std::uint32_t answered = 0;  // the newest report's tick

  void take(std::uint8_t byte, std::uint32_t now, Line& to_chip, Random& random) {
    Decoded outcome;
    Frame frame;
    if (!reader.take(byte, outcome, frame) || outcome != Decoded::frame || frame.type != FrameType::report || silent)
      return;
    std::uint8_t payload[8], wire[most_wire];
    Writer writer(payload);
    answered = Reader(frame.payload).u32();
    writer.u32(answered);
    writer.i16(full / 2);
    writer.i16(0);
    to_chip.put(wire, encode_frame(FrameType::command, 0, payload, wire), now, random);
  }
};

// How old [ms] the newest report that the PC had answered was, at most, while the chip drove; and whether it drove.
struct Worst {
  std::uint32_t age = 0;
  bool drove = false, came_back = false;
};

// For a while all sorts of things happen at once, then all is well again.
Worst run_schedule(Random& random) {
  Bench bench;
  Line to_pc, to_chip;
  Answering pc;
  Worst worst;
  const int length = 400 + static_cast<int>(random() % 800);
  for (int ms = 0; ms < length + 600; ++ms) {
    if (ms == 230) bench.stick(ahead);
    const bool over = ms >= length;
    if (over || (ms > 250 && random() % 100 == 0)) {
      const auto chance = [&](unsigned one_in) { return !over && random() % one_in == 0; };
      to_pc.cut = chance(4), to_chip.cut = chance(4), pc.silent = chance(4);
      to_pc.garbage = chance(4), to_chip.garbage = chance(4);
      to_pc.delay = chance(3) ? static_cast<std::uint32_t>(random() % 300) : 0;
      to_chip.delay = chance(3) ? static_cast<std::uint32_t>(random() % 300) : 0;
      if (chance(3)) std::shuffle(to_chip.bytes.begin(), to_chip.bytes.end(), random);
    }
    bench.run(1);
    const std::uint32_t now = bench.pins.now;
    if (now % report_ms == 0) {
      std::uint8_t wire[most_wire];
      to_pc.put(wire, bench.chip.report(now, wire), now, random);
    }
    for (; !to_pc.bytes.empty() && to_pc.bytes.front().due <= now; to_pc.bytes.pop_front())
      pc.take(to_pc.bytes.front().byte, now, to_chip, random);
    for (; !to_chip.bytes.empty() && to_chip.bytes.front().due <= now; to_chip.bytes.pop_front())
      bench.chip.take(to_chip.bytes.front().byte, now);
    if (is_zero(bench.chip.output())) continue;
    worst.drove = true;
    worst.age = std::max(worst.age, now - pc.answered);
  }
  worst.came_back = bench.chip.state() == State::driving;
  return worst;
}

// hazard: The link to the chair fails | requirement:
// cut, silent, delayed, garbled, shuffled: neutral once the last report that was answered is 100 ms old, and it drives
// again when all is well
// | count: 500 schedules on a virtual clock, LFDCORE_LINK_SCHEDULES
TEST(JoystickFirmware, whatever_the_link_does_nothing_moves_on_an_answer_to_a_report_older_than_100_ms) {
  const long schedules = test::count_from("LFDCORE_LINK_SCHEDULES", 500);
  long drove = 0, late = 0;
  for (long n = 0; n < schedules; ++n) {
    Random random(static_cast<std::uint64_t>(n));
    const Worst worst = run_schedule(random);
    drove += worst.drove;
    late += worst.age > command_ms;
    EXPECT_TRUE(worst.came_back) << n;
  }
  std::printf("%ld schedules, in %ld of them the chair drove, in %ld too long\n", schedules, drove, late);
  EXPECT_EQ(late, 0);
  EXPECT_EQ(drove, schedules);
}

}  // namespace
}  // namespace joystick
}  // namespace lfdcore
