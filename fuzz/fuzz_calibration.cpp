// Any calibration record: what is_sound takes, gives sticks and outputs in range, in order, for every reading there is.
// Inputs are what a sound record is changed by; whole nonsense is refused too easily.
#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "lfdcore/hardware/calibration.hpp"
#include "require_true.hpp"

namespace {

using namespace lfdcore::joystick;

const Calibration usual = {
    {{200, 512, 824, 20}, {824, 512, 200, 20}}, {{1000, 2048, 3096}, {3096, 2048, 1000}}, {100, 50, 25, 10}};

void check_axis(const AxisCalibration& axis) {
  require_true(stick_of(axis, axis.centre) == 0, "the centre is neutral");
  require_true(stick_of(axis, axis.plus) == full && stick_of(axis, axis.minus) == -full, "the ends are full");
  const int up = axis.plus > axis.minus ? 1 : -1;
  for (std::uint16_t count = 0; count < adc_top; ++count) {
    const std::int16_t here = stick_of(axis, count), next = stick_of(axis, static_cast<std::uint16_t>(count + 1));
    require_true(here >= -full && here <= full, "a stick is in range");
    require_true(up * (next - here) >= 0, "a stick goes one way");
  }
  require_true(!is_plausible(axis, 0) && !is_plausible(axis, adc_top), "a broken wire is found");
}

void check_output(const OutputCalibration& output) {
  const std::uint16_t low = lesser(output.minus, output.plus), high = greater(output.minus, output.plus);
  for (int value = -full; value <= full; value += 50) {
    const std::uint16_t code = code_of(output, static_cast<std::int16_t>(value));
    require_true(code >= low && code <= high, "an output lies between its ends");
  }
  require_true(code_of(output, 0) == output.neutral, "0 is neutral");
}

void check(const std::uint8_t* record) {
  const Calibration calibration = read_calibration(record);
  std::uint8_t again[calibration_bytes];
  write_calibration(calibration, again);
  require_true(std::equal(record, record + calibration_bytes, again), "a record is written as it was read");
  if (!is_sound(calibration)) return;
  for (std::uint8_t i = 0; i < axes; ++i) {
    check_axis(calibration.axis[i]);
    check_output(calibration.output[i]);
  }
}

}  // namespace

// Pairs of bytes: where, and by what.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::uint8_t record[calibration_bytes];
  write_calibration(usual, record);
  for (std::size_t i = 0; i + 1 < std::min<std::size_t>(size, 24); i += 2)
    record[data[i] % calibration_bytes] ^= data[i + 1];
  check(record);
  return 0;
}
