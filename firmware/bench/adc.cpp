#include "adc.hpp"

#include <algorithm>
#include <utility>

#include "registers.hpp"
#include "simavr/avr_adc.h"

namespace bench {

namespace {

constexpr double avcc = 5000, bandgap = 1100;  // [mV]
constexpr unsigned largest = 1023;

}  // namespace

Adc::Adc(Chip& chip, std::function<void(std::size_t, unsigned)> tell) : chip_(chip), tell_(std::move(tell)) {
  avr_irq_t* begins = avr_io_getirq(chip.avr(), AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_OUT_TRIGGER);
  avr_irq_register_notify(begins, [](avr_irq_t*, uint32_t, void* self) { static_cast<Adc*>(self)->sample(); }, this);
  chip.on_read(ADCL, [this] { return static_cast<uint8_t>(result()); });
  chip.on_read(ADCH, [this] { return static_cast<uint8_t>(result() >> 8); });
  chip.on_reset([this] { before_ = newest_ = 0; });
}

void Adc::sample() {
  before_ = newest_;
  newest_ = convert();
  if (std::exchange(last_[channel()], newest_) != newest_) tell_(channel(), newest_);
}

unsigned Adc::channel() const { return chip_.at(ADMUX) & 15; }

// An Uno's AREF pin is open: as a reference, it lets everything read full scale.
unsigned Adc::convert() const {
  const unsigned reference = chip_.at(ADMUX) >> 6;
  const double full = reference == 1 ? avcc : reference == 3 ? bandgap : 0;
  const double input = channel() < millivolts_.size() ? millivolts_[channel()] : channel() == 14 ? bandgap : 0;
  return input >= full ? largest : static_cast<unsigned>(std::max(0.0, input / full * 1024));
}

uint16_t Adc::result() const {
  const unsigned code = chip_.at(ADCSRA) & ADSC ? before_ : newest_;
  return static_cast<uint16_t>(chip_.at(ADMUX) & ADLAR ? code << 6 : code);
}

}  // namespace bench
