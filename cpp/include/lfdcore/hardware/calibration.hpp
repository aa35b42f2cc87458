// What a joystick's voltages mean, and what voltages the chair's controller takes (docs/joystick-link.md).
// Freestanding C++11 without the standard library: the firmware includes this very file.
#pragma once

#include "lfdcore/hardware/frame_codec.hpp"

namespace lfdcore {
namespace joystick {

/// A stick that is fully ahead or to the left. Sticks and outputs are counted in 1 / 10000.
constexpr int16_t full = 10000;

constexpr uint16_t adc_top = 1023, dac_top = 4095;
/// [ADC counts] beyond the calibrated ends at which a wire is broken or short. The ends keep away from 0 and the top by
/// more than twice as much: a broken wire reads up to 2.4 % of the supply, and one at a stick that lost its ground 97.5
/// %.
constexpr uint16_t adc_guard = 25;
constexpr uint16_t least_adc_span = 50, least_dac_span = 100;

/// One axis of the stick [ADC counts]: which way it is wired does not matter.
struct AxisCalibration {
  uint16_t minus;      ///< fully back, or to the right
  uint16_t centre;     ///< let go
  uint16_t plus;       ///< fully ahead, or to the left
  uint16_t dead_zone;  ///< about the centre: counts as 0
};

/// One input of the chair's controller [DAC codes].
struct OutputCalibration {
  uint16_t minus;    ///< fully back, or to the right
  uint16_t neutral;  ///< stand still
  uint16_t plus;     ///< fully ahead, or to the left
};

constexpr uint8_t axes = 2;  ///< 0: forward, 1: left
constexpr uint8_t profiles = 4;

struct Calibration {
  AxisCalibration axis[axes];
  OutputCalibration output[axes];
  uint8_t profile_percent[profiles];  ///< of the full output that a profile gives, 1 to 100
};

constexpr size_t calibration_bytes = 32;

inline void write_calibration(const Calibration& calibration, uint8_t* to) {
  Writer writer(to);
  for (uint8_t i = 0; i < axes; ++i) {
    const AxisCalibration& axis = calibration.axis[i];
    writer.u16(axis.minus);
    writer.u16(axis.centre);
    writer.u16(axis.plus);
    writer.u16(axis.dead_zone);
  }
  for (uint8_t i = 0; i < axes; ++i) {
    const OutputCalibration& output = calibration.output[i];
    writer.u16(output.minus);
    writer.u16(output.neutral);
    writer.u16(output.plus);
  }
  for (uint8_t i = 0; i < profiles; ++i) writer.u8(calibration.profile_percent[i]);
}

inline Calibration read_calibration(const uint8_t* from) {
  Reader reader(from);
  Calibration calibration;
  for (uint8_t i = 0; i < axes; ++i) {
    AxisCalibration& axis = calibration.axis[i];
    axis.minus = reader.u16();
    axis.centre = reader.u16();
    axis.plus = reader.u16();
    axis.dead_zone = reader.u16();
  }
  for (uint8_t i = 0; i < axes; ++i) {
    OutputCalibration& output = calibration.output[i];
    output.minus = reader.u16();
    output.neutral = reader.u16();
    output.plus = reader.u16();
  }
  for (uint8_t i = 0; i < profiles; ++i) calibration.profile_percent[i] = reader.u8();
  return calibration;
}

inline uint16_t lesser(uint16_t a, uint16_t b) { return a < b ? a : b; }
inline uint16_t greater(uint16_t a, uint16_t b) { return a < b ? b : a; }
inline uint16_t distance(uint16_t a, uint16_t b) { return static_cast<uint16_t>(greater(a, b) - lesser(a, b)); }

/// Whether `middle` lies between both ends, away from each by `span` or more, in whichever order.
inline bool lies_between(uint16_t minus, uint16_t middle, uint16_t plus, uint16_t span) {
  return (minus < middle) == (middle < plus) && distance(minus, middle) >= span && distance(middle, plus) >= span;
}

inline bool is_sound(const AxisCalibration& axis) {
  const uint16_t low = lesser(axis.minus, axis.plus), high = greater(axis.minus, axis.plus);
  const uint16_t shorter = lesser(distance(axis.minus, axis.centre), distance(axis.centre, axis.plus));
  return lies_between(axis.minus, axis.centre, axis.plus, least_adc_span) && low > 2 * adc_guard &&
         high < adc_top - 2 * adc_guard && axis.dead_zone <= shorter / 2;
}

inline bool is_sound(const OutputCalibration& output) {
  return lies_between(output.minus, output.neutral, output.plus, least_dac_span) && output.minus <= dac_top &&
         output.plus <= dac_top;
}

inline bool is_sound(const Calibration& calibration) {
  for (uint8_t i = 0; i < axes; ++i)
    if (!is_sound(calibration.axis[i]) || !is_sound(calibration.output[i])) return false;
  for (uint8_t i = 0; i < profiles; ++i)
    if (calibration.profile_percent[i] < 1 || calibration.profile_percent[i] > 100) return false;
  return true;
}

/// Whether an ADC count may come from a stick whose wires are whole.
inline bool is_plausible(const AxisCalibration& axis, uint16_t count) {
  const uint16_t low = lesser(axis.minus, axis.plus), high = greater(axis.minus, axis.plus);
  return count + adc_guard >= low && count <= high + adc_guard;
}

/// The stick's place, -full to full: 0 in the dead zone, from its edge on in proportion. For a sound calibration.
inline int16_t stick_of(const AxisCalibration& axis, uint16_t count) {
  const uint16_t away = distance(count, axis.centre);
  if (away <= axis.dead_zone) return 0;
  const bool to_plus = (count > axis.centre) == (axis.plus > axis.centre);
  const uint16_t span = distance(to_plus ? axis.plus : axis.minus, axis.centre);
  const uint32_t share = static_cast<uint32_t>(away - axis.dead_zone) * full / (span - axis.dead_zone);
  const int16_t value = share > static_cast<uint32_t>(full) ? full : static_cast<int16_t>(share);
  return to_plus ? value : static_cast<int16_t>(-value);
}

/// The DAC's code for an output of -full to full. For a sound calibration.
inline uint16_t code_of(const OutputCalibration& output, int16_t value) {
  const int32_t end = value < 0 ? output.minus : output.plus, size = value < 0 ? -value : value;
  return static_cast<uint16_t>(output.neutral + (end - output.neutral) * size / full);
}

}  // namespace joystick
}  // namespace lfdcore
