// What may move the chair, and when: one table for the PC and the chip (docs/joystick-link.md draws it), and the limits
// that the stick sets. Freestanding C++11 without the standard library: the firmware includes this very file.
#pragma once

#include "lfdcore/hardware/calibration.hpp"

namespace lfdcore {
namespace joystick {

/// Only in `driving` is the output anything but neutral.
enum class State : uint8_t {
  neutral_required,  ///< at start, after a fault, after a change of settings: until the stick is at neutral
  ready,             ///< no fresh command
  driving,
  fault,
  emergency,     ///< the input is pressed, or its wire is broken
  disconnected,  ///< of the PC only: no report
};
constexpr uint8_t states = 6;

enum class Event : uint8_t {
  stick_neutral,  ///< on both axes for `neutral_ms`
  command_fresh,
  command_old,  ///< older than `command_ms` (chip), or an assistant that is silent for longer than it may (PC)
  fault_found,
  fault_gone,
  emergency_pressed,
  emergency_released,
  settings_changed,  ///< another profile or calibration
  link_lost,         ///< of the PC only
  link_made,         ///< of the PC only
};
constexpr uint8_t events = 10;

/// [ms] by the chip's clock: older commands are none
constexpr uint32_t command_ms = 100;
/// [ms] for which the stick must be at neutral
constexpr uint32_t neutral_ms = 200;
/// [ms] between two reports, and two readings of the stick
constexpr uint32_t report_ms = 10;
/// A reading of the stick beyond its ends adds so much to the doubt in its wire, another takes 1 away ...
constexpr uint8_t wire_weight = 4;
/// ... and this much is a broken wire, until the doubt is gone: three readings in a row, or a third of many.
constexpr uint8_t wire_doubt = 12;

inline State next(State state, Event event) {
  constexpr State N = State::neutral_required, R = State::ready, D = State::driving, F = State::fault,
                  E = State::emergency, X = State::disconnected;
  // clang-format off
  static constexpr State table[states][events] = {
      // neutral fresh old fault gone pressed released settings lost made
      {R, N, N, F, N, E, N, N, X, N},  // neutral_required
      {R, D, R, F, R, E, R, N, X, R},  // ready
      {D, D, R, F, D, E, D, N, X, D},  // driving
      {F, F, F, F, N, E, F, F, X, F},  // fault
      {E, E, E, E, E, E, N, E, X, E},  // emergency
      {X, X, X, X, X, X, X, X, X, N},  // disconnected
  };
  // clang-format on
  return table[static_cast<uint8_t>(state)][static_cast<uint8_t>(event)];
}

/// Why a chip is in `fault`: bits.
enum Fault : uint16_t {
  not_calibrated = 1,
  forward_wire = 2,  ///< the axis is beyond its calibrated ends
  left_wire = 4,
  dac_failed = 8,  ///< a DAC does not answer
  bad_command = 16,
  forward_memory = 32,  ///< the axis's DAC does not keep its neutral voltage through a power-up
  left_memory = 64,
};

/// Of stick or output: -full to full.
struct Axes {
  int16_t forward, left;
};

inline bool is_neutral(const Axes& stick) { return stick.forward == 0 && stick.left == 0; }

inline bool is_in_range(const Axes& value) {
  return value.forward >= -full && value.forward <= full && value.left >= -full && value.left <= full;
}

/// The whole root.
inline uint16_t square_root(uint32_t value) {
  uint16_t root = 0;
  for (uint16_t bit = 0x8000; bit != 0; bit = static_cast<uint16_t>(bit >> 1)) {
    const uint32_t more = static_cast<uint32_t>(root) | bit;
    if (more * more <= value) root = static_cast<uint16_t>(more);
  }
  return root;
}

inline int16_t held_within(int16_t value, int16_t most) {
  return value > most ? most : value < -most ? static_cast<int16_t>(-most) : value;
}

/// What the stick allows of an output: nothing at neutral; on neither axis more than the stick is out; no way ahead or
/// back that it is pulled against, and no turn against it while it asks for no way.
inline Axes allowed(const Axes& wanted, const Axes& stick) {
  if (is_neutral(stick)) return {0, 0};
  const int32_t x = stick.forward, y = stick.left;
  const uint16_t out = square_root(static_cast<uint32_t>(x * x) + static_cast<uint32_t>(y * y));
  const int16_t most = out > full ? full : static_cast<int16_t>(out);
  Axes given = {held_within(wanted.forward, most), held_within(wanted.left, most)};
  if ((given.forward < 0 && stick.forward >= 0) || (given.forward > 0 && stick.forward <= 0)) given.forward = 0;
  if (stick.forward == 0 && (given.left < 0) != (stick.left < 0)) given.left = 0;
  return given;
}

}  // namespace joystick
}  // namespace lfdcore
