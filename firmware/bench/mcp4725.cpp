#include "mcp4725.hpp"

namespace bench {

namespace {

constexpr Cycles longest_store = 50'000 * cycles_per_us;  // datasheet: 25 ms typical, 50 ms maximum
constexpr uint8_t write_dac = 0b010, write_dac_and_eeprom = 0b011;

}  // namespace

Mcp4725::Mcp4725(Chip& chip, uint8_t address, std::function<void(Cycles)> tell)
    : chip_(chip), address_(address), tell_(std::move(tell)), stored_(chip, [this](Cycles) { eeprom_ = storing_; }) {}

unsigned Mcp4725::output() const { return powered_ && register_ < 0x1000 ? register_ : 0; }

void Mcp4725::set_eeprom(unsigned code, bool worn) {
  eeprom_ = static_cast<Word>(code);
  worn_ = worn;
}

void Mcp4725::set_powered(bool powered) {
  const unsigned before = output();
  stored_.cancel();  // what was being stored is not
  powered_ = powered;
  register_ = eeprom_;
  if (output() != before) tell_(chip_.now());
}

bool Mcp4725::write(uint8_t byte, Cycles when) {
  const unsigned place = count_++;
  if (place == 0) command_ = byte;
  if (command_ < 0x40) {  // fast write, again and again
    if (place % 2 == 0) high_ = byte;
    if (place % 2 == 1) set(static_cast<Word>((high_ & 0x3F) << 8 | byte), when);
    return true;
  }
  if (place % 3 == 0) command_ = byte;
  if (place % 3 == 1) high_ = byte;
  if (place % 3 != 2) return true;
  const Word word = static_cast<Word>((command_ & 6) << 11 | high_ << 4 | byte >> 4);
  if (command_ >> 5 == write_dac) set(word, when);
  if (command_ >> 5 == write_dac_and_eeprom) store(word, when);
  return true;
}

void Mcp4725::set(Word word, Cycles when) {
  if (stored_.is_set()) return void(++ignored_);
  const unsigned before = output();
  register_ = word;
  written_ = when;
  ++writes_;
  if (output() != before) tell_(when);
}

void Mcp4725::store(Word word, Cycles when) {
  if (stored_.is_set()) return void(++ignored_);
  set(word, when);
  storing_ = worn_ ? eeprom_ : word;
  stored_.set(when + longest_store);
}

uint8_t Mcp4725::read() {
  const uint8_t mode = static_cast<uint8_t>(register_ >> 12), stored_mode = static_cast<uint8_t>(eeprom_ >> 12);
  switch (count_++ % 5) {
    case 0:
      return static_cast<uint8_t>((stored_.is_set() ? 0 : 0x80) | 0x40 | mode << 1);
    case 1:
      return static_cast<uint8_t>(register_ >> 4);
    case 2:
      return static_cast<uint8_t>(register_ << 4);
    case 3:
      return static_cast<uint8_t>(stored_mode << 5 | (eeprom_ >> 8 & 15));
    default:
      return static_cast<uint8_t>(eeprom_);
  }
}

}  // namespace bench
