// The chip's ADC: what it reads of the voltages at its pins. simavr's own reads them when the result is fetched, of
// whatever channel is chosen by then.
#pragma once

#include <array>
#include <functional>

#include "chip.hpp"

namespace bench {

class Adc {
 public:
  /// `tell` is called when a channel reads something new.
  Adc(Chip& chip, std::function<void(std::size_t channel, unsigned code)> tell);

  void set_millivolts(std::size_t channel, double millivolts) { millivolts_[channel] = millivolts; }
  double millivolts(std::size_t channel) const { return millivolts_[channel]; }

 private:
  void sample();
  unsigned channel() const;
  unsigned convert() const;
  uint16_t result() const;

  Chip& chip_;
  std::function<void(std::size_t, unsigned)> tell_;
  std::array<unsigned, 16> last_{};
  std::array<double, 8> millivolts_{2500, 2500};
  unsigned before_ = 0, newest_ = 0;  // the newest is still being made while ADSC is set
};

}  // namespace bench
