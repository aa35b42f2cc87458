#include "twi.hpp"

#include <utility>

#include "registers.hpp"
#include "simavr/avr_ioport.h"

namespace bench {

namespace {

constexpr uint8_t sda = 1 << 4, scl = 1 << 5;  // of port C
constexpr Cycles look_again = 10 * cycles_per_us;
constexpr uint8_t bits_per_byte = 9;

// Statuses of the datasheet's tables 22-2 and 22-3.
enum Status : uint8_t {
  started = 0x08,
  started_again = 0x10,
  write_ack = 0x18,
  write_nack = 0x20,
  data_ack = 0x28,
  data_nack = 0x30,
  arbitration_lost = 0x38,
  read_ack = 0x40,
  read_nack = 0x48,
  received_ack = 0x50,
  received_nack = 0x58,
  nothing_to_say = 0xF8
};

}  // namespace

Twi::Twi(Chip& chip, std::vector<BusDac> dacs)
    : chip_(chip),
      part_(chip.part<avr_twi_t>("twi")),
      dacs_(std::move(dacs)),
      done_(chip, [this](Cycles when) { end(when); }) {
  chip.on_write(TWCR, [this](uint8_t value) { write_control(value); });
  chip.on_write(TWDR, [this](uint8_t value) { chip_.at(TWDR) = value; });
  chip.on_write(TWSR, [this](uint8_t value) { chip_.at(TWSR) = (chip_.at(TWSR) & 0xF8) | (value & 3); });
  chip.on_read(TWDR, [this] { return chip_.at(TWDR); });
  chip.keep_raised(part_.twi, [this] { return (chip_.at(TWCR) & TWINT) != 0; });
  chip.after_write(DDRC, [this] { watch_clock(); });
  chip.after_write(PORTC, [this] { watch_clock(); });
  chip.on_reset([this] { reset(); });
}

Cycles Twi::bit() const { return 16 + 2 * chip_.at(TWBR) * (Cycles{1} << 2 * (chip_.at(TWSR) & 3)); }

bool Twi::sda_held() const {
  for (const BusDac& each : dacs_)
    if (each.stuck && !each.absent) return true;
  return false;
}

// Pull-ups of the bus hold both wires high where nobody pulls them low.
void Twi::renew_pins() {
  const uint8_t high = static_cast<uint8_t>(scl | (sda_held() ? 0 : sda));
  avr_ioport_external_t pulled = {'C', sda | scl, high};
  avr_ioctl(chip_.avr(), AVR_IOCTL_IOPORT_SET_EXTERNAL('C'), &pulled);
  chip_.at(PINC) = static_cast<uint8_t>((chip_.at(PINC) & ~(sda | scl)) | high);
}

void Twi::reset() {
  done_.cancel();
  doing_ = Doing::nothing;
  release_bus();
  chip_.at(TWSR) = nothing_to_say;
  chip_.at(TWDR) = 0xFF;
  renew_pins();
}

void Twi::release_bus() {
  owns_bus_ = addressed_ = false;
  selected_ = nullptr;
}

// A rising clock that the chip makes without its two-wire interface, to free the bus.
void Twi::watch_clock() {
  const bool high = !(chip_.at(DDRC) & scl) || chip_.at(PORTC) & scl;
  const bool rises = high && !clock_was_high_ && !(chip_.at(TWCR) & TWEN);
  clock_was_high_ = high;
  if (!rises) return;
  for (BusDac& each : dacs_)
    if (each.stuck && each.clocks > 0 && --each.clocks == 0) each.stuck = false;
  renew_pins();
}

void Twi::write_control(uint8_t value) {
  const uint8_t before = chip_.at(TWCR);
  chip_.at(TWCR) = static_cast<uint8_t>((value & (TWEA | TWSTA | TWSTO | TWEN | TWIE)) | (before & TWINT));
  if (value & TWINT) chip_.lower(part_.twi);
  if (!(value & TWEN)) return reset();
  acknowledges_ = value & TWEA;
  if (value & TWIE && chip_.at(TWCR) & TWINT) chip_.raise(part_.twi);
  if (done_.is_set() || chip_.at(TWCR) & TWINT) return;
  if (value & TWSTO) return begin(Doing::stop, chip_.now());
  if (value & TWSTA) return begin(Doing::start, chip_.now());
  if (value & TWINT && owns_bus_) begin(Doing::byte, chip_.now());
}

void Twi::begin(Doing what, Cycles when) {
  doing_ = what;
  done_.set(when + bit() * (what == Doing::byte ? bits_per_byte : 1));
}

void Twi::end(Cycles when) {
  const bool waits = doing_ != Doing::byte && sda_held();
  if (waits) return done_.set(when + look_again);  // neither START nor STOP can be made while SDA is held low
  switch (std::exchange(doing_, Doing::nothing)) {
    case Doing::start:
      return end_start(when);
    case Doing::stop:
      return end_stop(when);
    case Doing::byte:
      return end_byte(when);
    case Doing::nothing:
      return;
  }
}

void Twi::end_start(Cycles) {
  const uint8_t status = owns_bus_ ? started_again : started;
  release_bus();
  owns_bus_ = true;
  finish(status);
}

void Twi::end_stop(Cycles when) {
  release_bus();
  chip_.at(TWCR) &= static_cast<uint8_t>(~TWSTO);
  chip_.at(TWSR) |= nothing_to_say;
  if (chip_.at(TWCR) & TWSTA) begin(Doing::start, when);
}

void Twi::end_byte(Cycles when) {
  const uint8_t byte = chip_.at(TWDR);
  if (sda_held() && !(addressed_ && reads_) && byte != 0) {
    release_bus();
    return finish(arbitration_lost);
  }
  if (!addressed_) return finish(send_address(byte));
  finish(reads_ ? receive_data() : send_data(byte, when));
}

uint8_t Twi::send_address(uint8_t byte) {
  addressed_ = true;
  reads_ = byte & 1;
  selected_ = nullptr;
  for (BusDac& each : dacs_)
    if (each.dac.address() == byte >> 1 && !each.absent) selected_ = &each;
  if (selected_) selected_->dac.begin();
  return reads_ ? (selected_ ? read_ack : read_nack) : (selected_ ? write_ack : write_nack);
}

uint8_t Twi::send_data(uint8_t byte, Cycles when) {
  const bool heard = selected_ && !selected_->absent && selected_->dac.write(byte, when);
  return heard ? data_ack : data_nack;
}

uint8_t Twi::receive_data() {
  const bool answers = selected_ && !selected_->absent;
  chip_.at(TWDR) = sda_held() ? 0 : answers ? selected_->dac.read() : 0xFF;
  return acknowledges_ ? received_ack : received_nack;
}

void Twi::finish(uint8_t status) {
  chip_.at(TWSR) = static_cast<uint8_t>(status | (chip_.at(TWSR) & 3));
  chip_.raise(part_.twi);
}

}  // namespace bench
