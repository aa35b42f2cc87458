// The chip's ADC: what it reads of the voltages at its pins. simavr's own reads them when the result is fetched, of
// whatever channel is chosen by then.
#pragma once

#include <array>

#include "chip.hpp"

namespace bench {

class Adc {
 public:
  explicit Adc(Chip& chip);

  void set_millivolts(std::size_t channel, double millivolts) { millivolts_[channel] = millivolts; }
  double millivolts(std::size_t channel) const { return millivolts_[channel]; }

 private:
  unsigned convert() const;
  uint16_t result() const;

  Chip& chip_;
  std::array<double, 8> millivolts_{2500, 2500};
  unsigned before_ = 0, newest_ = 0;  // the newest is still being made while ADSC is set
};

}  // namespace bench
