// The chip's EEPROM: a byte takes 3.4 ms, and is lost where the power fails meanwhile. simavr's own takes no time.
#pragma once

#include <array>
#include <string>

#include "chip.hpp"
#include "simavr/avr_eeprom.h"

namespace bench {

class Eeprom {
 public:
  static constexpr std::size_t size = 1024;

  /// Its content comes from `file`, where there is one; else from the firmware, or it is erased. An empty name: no
  /// file. Throws std::runtime_error for a file of another size.
  Eeprom(Chip& chip, std::string file);

  /// Writes the file, where one was named and anything has changed.
  void save();

 private:
  void load();
  void write_control(uint8_t value);
  void begin_write(uint8_t mode);
  uint16_t address() const;

  Chip& chip_;
  avr_eeprom_t& part_;
  std::string file_;
  Alarm written_;
  Cycles unlocked_until_ = 0;
  uint16_t writing_at_ = 0;
  uint8_t writing_ = 0;
  bool changed_ = false;
};

}  // namespace bench
