#include "pins.hpp"

#include <cmath>

#include "registers.hpp"
#include "simavr/avr_ioport.h"

namespace bench {

namespace {

constexpr unsigned first_pin = 2;
constexpr uint8_t used = 0xFC;

}  // namespace

InputPins::InputPins(Chip& chip) : chip_(chip) {
  levels_.fill(Level::open);
  for (std::size_t pin = 0; pin < irqs_.size(); ++pin)
    irqs_[pin] = avr_io_getirq(chip.avr(), AVR_IOCTL_IOPORT_GETIRQ('D'), static_cast<int>(pin));
  for (const uint16_t address : {PORTD, DDRD, MCUCR}) chip.after_write(address, [this] { renew(); });
  chip.on_reset([this] {
    // simavr cleared the register, and takes no level for new that the pin had before
    for (avr_irq_t* irq : irqs_) irq->value = 0;
    renew();
  });
  renew();
}

bool InputPins::high(unsigned pin) const {
  if (levels_[pin] != Level::open) return levels_[pin] == Level::high;
  return chip_.at(PORTD) >> pin & 1 && !(chip_.at(MCUCR) & PUD);
}

void InputPins::set(unsigned pin, Level level) {
  levels_[pin] = level;
  renew();
}

// simavr must know them as external levels, too: else it takes a pin with a pull-up for high at every write to the
// port.
void InputPins::renew() {
  uint8_t levels = 0;
  for (unsigned pin = first_pin; pin < levels_.size(); ++pin)
    if (high(pin)) levels = static_cast<uint8_t>(levels | 1 << pin);
  avr_ioport_external_t external = {'D', used, levels};
  avr_ioctl(chip_.avr(), AVR_IOCTL_IOPORT_SET_EXTERNAL('D'), &external);
  for (unsigned pin = first_pin; pin < levels_.size(); ++pin)
    if (!(chip_.at(DDRD) >> pin & 1)) avr_raise_irq(irqs_[pin], levels >> pin & 1);
}

Encoder::Encoder(Chip& chip, InputPins& pins, unsigned pin_a, unsigned pin_b)
    : chip_(chip), pins_(pins), pin_a_(pin_a), pin_b_(pin_b), edge_(chip, [this](Cycles) { step(); }) {
  pins_.set(pin_a_, Level::low);
  pins_.set(pin_b_, Level::low);
}

double Encoder::position(Cycles when) const {
  return since_position_ + rate_ * (static_cast<double>(when - since_) / (1e6 * cycles_per_us));
}

void Encoder::set_rate(double rate) {
  since_position_ = position(chip_.now());
  since_ = chip_.now();
  rate_ = rate;
  plan();
}

// Edge k lies at position k: forward the next one is edges + 1, backward the one just made.
void Encoder::plan() {
  edge_.cancel();
  if (rate_ == 0) return;
  const double target = static_cast<double>(rate_ > 0 ? edges_ + 1 : edges_);
  const double cycles = std::ceil((target - since_position_) / rate_ * 1e6 * cycles_per_us);
  if (cycles < 1e15) edge_.set(since_ + static_cast<Cycles>(std::max(0.0, cycles)));
}

void Encoder::step() {
  edges_ += rate_ > 0 ? 1 : -1;
  const unsigned phase = static_cast<unsigned>(edges_ & 3);  // low low, high low, high high, low high
  pins_.set(pin_a_, phase == 1 || phase == 2 ? Level::high : Level::low);
  pins_.set(pin_b_, phase >= 2 ? Level::high : Level::low);
  plan();
}

Contact::Contact(InputPins& pins, unsigned pin, bool closed) : pins_(pins), pin_(pin), closed_(closed) { renew(); }

void Contact::set_closed(bool closed) {
  closed_ = closed;
  renew();
}

void Contact::set_broken(bool broken) {
  broken_ = broken;
  renew();
}

void Contact::renew() { pins_.set(pin_, closed_ && !broken_ ? Level::low : Level::open); }

EnableLine::EnableLine(Chip& chip, std::function<void(Cycles)> tell) : chip_(chip), tell_(std::move(tell)) {
  for (const uint16_t address : {PINB, DDRB, PORTB}) chip.after_write(address, [this] { renew(); });
  chip.on_reset([this] { renew(); });
}

void EnableLine::renew() {
  const bool high = chip_.at(DDRB) & chip_.at(PORTB) & 1;
  if (high == high_) return;
  high_ = high;
  changed_ = chip_.now();
  tell_(changed_);
}

}  // namespace bench
