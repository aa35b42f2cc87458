// The chip's two-wire interface as a master, with the bus and the DACs on it, and what may be wrong with them.
// simavr's own takes 1 us a bit whatever TWBR says, and answers an address with the status of a data byte.
#pragma once

#include <optional>
#include <vector>

#include "chip.hpp"
#include "mcp4725.hpp"
#include "simavr/avr_twi.h"

namespace bench {

/// A DAC and its wires.
struct BusDac {
  Mcp4725& dac;
  bool absent = false;  ///< its wires are cut: it answers nothing, and keeps its output
  bool stuck = false;   ///< it holds SDA low
  /// A stuck one lets go after so many clocks that the chip makes as plain port pins; 0: never
  unsigned clocks = 0;
};

class Twi {
 public:
  Twi(Chip& chip, std::vector<BusDac> dacs);

  BusDac& dac(std::size_t index) { return dacs_[index]; }
  bool sda_held() const;
  /// The wires changed.
  void renew_pins();

 private:
  enum class Doing { nothing, start, stop, byte };

  Cycles bit() const;
  void write_control(uint8_t value);
  void begin(Doing what, Cycles when);
  void end(Cycles when);
  void end_start(Cycles when);
  void end_stop(Cycles when);
  void end_byte(Cycles when);
  uint8_t send_address(uint8_t byte);
  uint8_t send_data(uint8_t byte, Cycles when);
  uint8_t receive_data();
  void finish(uint8_t status);
  void release_bus();
  void watch_clock();
  void reset();

  Chip& chip_;
  avr_twi_t& part_;
  std::vector<BusDac> dacs_;
  Alarm done_;
  Doing doing_ = Doing::nothing;
  bool owns_bus_ = false, addressed_ = false, reads_ = false, acknowledges_ = false, clock_was_high_ = true;
  BusDac* selected_ = nullptr;
};

}  // namespace bench
