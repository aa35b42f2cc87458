#include "eeprom.hpp"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "registers.hpp"

namespace bench {

namespace {

constexpr Cycles erase_and_write = 3400 * cycles_per_us, half_of_it = 1800 * cycles_per_us;
constexpr Cycles unlocked_for = 6;  // 4 after the instruction that unlocks, which ends 2 later

}  // namespace

Eeprom::Eeprom(Chip& chip, std::string file)
    : chip_(chip), part_(chip.part<avr_eeprom_t>("eeprom")), file_(std::move(file)), written_(chip, [this](Cycles) {
        part_.eeprom[writing_at_] = writing_;
        if (chip_.at(EECR) & EERIE) chip_.raise(part_.ready);
      }) {
  if (!file_.empty() && std::filesystem::exists(file_)) load();
  chip.on_write(EECR, [this](uint8_t value) { write_control(value); });
  chip.on_read(EECR, [this] {
    const int unlocked = chip_.now() < unlocked_until_ ? EEMPE : 0, busy = written_.is_set() ? EEPE : 0;
    return static_cast<uint8_t>((chip_.at(EECR) & (EEPM0 | EEPM1 | EERIE)) | unlocked | busy);
  });
  chip.keep_raised(part_.ready, [this] { return chip_.at(EECR) & EERIE && !written_.is_set(); });
  chip.on_power_off([this] { written_.cancel(); });
}

void Eeprom::load() {
  std::ifstream in(file_, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  if (!in || bytes.size() != size)
    throw std::runtime_error(file_ + " holds " + std::to_string(bytes.size()) +
                             " bytes, an EEPROM's file has 1024: name another, or one that does not exist yet");
  std::copy(bytes.begin(), bytes.end(), part_.eeprom);
}

void Eeprom::save() {
  if (file_.empty() || !changed_ || written_.is_set()) return;
  const std::string fresh = file_ + ".new";
  std::ofstream out(fresh, std::ios::binary);
  out.write(reinterpret_cast<const char*>(part_.eeprom), size);
  out.close();
  if (!out || std::rename(fresh.c_str(), file_.c_str()) != 0)
    throw std::runtime_error("the EEPROM cannot be saved to " + file_);
  changed_ = false;
}

uint16_t Eeprom::address() const { return static_cast<uint16_t>((chip_.at(EEARL) | chip_.at(EEARH) << 8) % size); }

void Eeprom::write_control(uint8_t value) {
  const bool unlocked = chip_.now() < unlocked_until_, busy = written_.is_set();
  chip_.at(EECR) = value & (EEPM0 | EEPM1 | EERIE);
  if (value & EERE && !busy) chip_.at(EEDR) = part_.eeprom[address()];
  if (value & EEPE && unlocked && !busy) return begin_write(value & (EEPM0 | EEPM1));
  if (value & EEMPE && !(value & EEPE)) unlocked_until_ = chip_.now() + unlocked_for;
  if (value & EERIE && !busy) chip_.raise(part_.ready);
}

// While it is written, a byte is erased.
void Eeprom::begin_write(uint8_t mode) {
  const bool erases = mode != EEPM1, writes = mode != EEPM0;
  unlocked_until_ = 0;
  changed_ = true;
  writing_at_ = address();
  uint8_t& byte = part_.eeprom[writing_at_];
  if (erases) byte = 0xFF;
  writing_ = writes ? static_cast<uint8_t>(byte & chip_.at(EEDR)) : byte;
  written_.set(chip_.now() + (erases && writes ? erase_and_write : half_of_it));
}

}  // namespace bench
