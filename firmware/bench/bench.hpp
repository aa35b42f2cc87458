// The chip with everything that is connected to its pins.
#pragma once

#include <functional>
#include <string>

#include "adc.hpp"
#include "chip.hpp"
#include "eeprom.hpp"
#include "mcp4725.hpp"
#include "pins.hpp"
#include "serial_line.hpp"
#include "twi.hpp"

namespace bench {

/// [us], with the four digits that a cycle needs.
std::string microseconds(Cycles when);

class Bench {
 public:
  /// `received` gets the bytes that come to the PC, `event` what happens at the DACs, the enable line and the reset:
  /// "dac0 CODE", "dac1 CODE", "enable 0|1", "reset CAUSE".
  Bench(const std::string& elf, const std::string& eeprom_file, std::function<void(Cycles, uint8_t)> received,
        std::function<void(Cycles, const std::string&)> event);

  void power(bool on);
  /// All that can be seen, in one line of JSON.
  std::string state() const;

  Chip chip;

 private:
  std::function<void(Cycles, const std::string&)> event_;
  Mcp4725 forward_dac_, left_dac_;

 public:
  Eeprom eeprom;
  Adc adc;
  SerialLine line;
  Twi twi;
  InputPins inputs;
  Encoder left_encoder, right_encoder;
  Contact manual, emergency;
  EnableLine enable;
};

}  // namespace bench
