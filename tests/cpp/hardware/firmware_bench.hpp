// The firmware's own logic with a stick, a clock and a line, in no real time.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <deque>
#include <random>

#include "../../../firmware/joystick/joystick.hpp"

namespace lfdcore {
namespace joystick {

using Random = std::mt19937_64;

inline const Calibration usual = {
    {{200, 512, 824, 20}, {824, 512, 200, 20}}, {{1000, 2048, 3096}, {3096, 2048, 1000}}, {100, 50, 25, 10}};
constexpr std::uint16_t centre = 512, ahead = 824, back = 200, broken = 0;

inline bool is_zero(const Output& output) {
  return output.code[0] == usual.output[0].neutral && output.code[1] == usual.output[1].neutral;
}

// A chip with its stick and its clock; a byte arrives in no time.
struct Bench {
  Joystick chip;
  Reading pins = {1000, {centre, centre}, {0, 0}, 0, false, false};
  std::uint8_t sequence = 0;

  explicit Bench(const Calibration* stored = &usual) : chip(stored) {}

  void send(FrameType type, const std::uint8_t* payload) {
    std::uint8_t wire[most_wire];
    const std::size_t count = encode_frame(type, sequence++, payload, wire);
    for (std::size_t i = 0; i < count; ++i) chip.take(wire[i], pins.now);
  }
  void command(std::uint32_t tick, const Axes& value) {
    std::uint8_t payload[8];
    Writer writer(payload);
    writer.u32(tick);
    writer.i16(value.forward);
    writer.i16(value.left);
    send(FrameType::command, payload);
  }
  void select(std::uint8_t profile) { send(FrameType::select_profile, &profile); }
  void calibrate(const Calibration& calibration) {
    std::uint8_t payload[calibration_bytes];
    write_calibration(calibration, payload);
    send(FrameType::set_calibration, payload);
  }
  // Milliseconds, with the chip's own rhythm.
  void run(int ms) {
    for (int i = 0; i < ms; ++i) {
      ++pins.now;
      chip.watch(pins.now);
      if (pins.now % report_ms == 0) chip.look(pins);
    }
  }
  // A PC that answers each report.
  void run_answered(int ms, const Axes& value) {
    for (int i = 0; i < ms; ++i) {
      run(1);
      if (pins.now % report_ms == 0) command(pins.now, value);
    }
  }
  void stick(std::uint16_t forward, std::uint16_t left = centre) {
    pins.adc[0] = forward;
    pins.adc[1] = left;
  }
  // Neutral first, then the stick ahead.
  void set_off() {
    stick(centre);
    run_answered(300, {});
    stick(ahead);
    run_answered(20, {full / 2, 0});
    EXPECT_EQ(chip.state(), State::driving);
  }
};

// A line that delays, loses, repeats, garbles and freezes, both ways.
struct Line {
  struct Byte {
    std::uint32_t due;
    std::uint8_t byte;
  };
  std::deque<Byte> bytes;
  std::uint32_t delay = 0;
  bool cut = false, garbage = false;

  void put(const std::uint8_t* from, std::size_t count, std::uint32_t now, Random& random) {
    for (std::size_t i = 0; i < count && !cut; ++i) {
      const auto wrong = static_cast<std::uint8_t>(garbage && random() % 8 == 0 ? random() : 0);
      bytes.push_back({now + delay, static_cast<std::uint8_t>(from[i] ^ wrong)});
    }
  }
};

}  // namespace joystick
}  // namespace lfdcore
