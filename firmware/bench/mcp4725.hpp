// An MCP4725: a 12-bit DAC on the two-wire bus, with an EEPROM for its value at power-up.
#pragma once

#include <functional>

#include "chip.hpp"

namespace bench {

class Mcp4725 {
 public:
  /// `tell` is called when its output changes.
  Mcp4725(Chip& chip, uint8_t address, std::function<void(Cycles)> tell);

  uint8_t address() const { return address_; }
  /// 0..4095, as a share of its supply; 0 also without power, and in its power-down modes.
  unsigned output() const;
  unsigned eeprom() const { return eeprom_ & 0xFFF; }
  unsigned writes() const { return writes_; }
  unsigned ignored() const { return ignored_; }
  Cycles written() const { return written_; }
  /// Worn: it acknowledges another code, and does not keep it.
  void set_eeprom(unsigned code, bool worn);
  void set_powered(bool powered);

  void begin() { count_ = 0; }
  /// A byte after the address -> acknowledged.
  bool write(uint8_t byte, Cycles when);
  uint8_t read();

 private:
  // as the device keeps them: power-down mode << 12 | code
  using Word = uint16_t;

  void set(Word word, Cycles when);
  void store(Word word, Cycles when);

  Chip& chip_;
  uint8_t address_;
  std::function<void(Cycles)> tell_;
  Alarm stored_;  // it is busy until then
  Word register_ = 0x800, eeprom_ = 0x800, storing_ = 0;
  bool powered_ = true, worn_ = false;
  unsigned count_ = 0, writes_ = 0, ignored_ = 0;
  uint8_t command_ = 0, high_ = 0;
  Cycles written_ = 0;
};

}  // namespace bench
