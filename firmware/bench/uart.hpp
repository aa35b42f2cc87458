// The chip's UART 0 as the datasheet has it: two bytes of receive buffer and a shift register, one byte of transmit
// buffer and a shift register. simavr's own has 64 bytes of buffer, and 11 bits a byte.
#pragma once

#include <deque>

#include "chip.hpp"
#include "simavr/avr_uart.h"

namespace bench {

class Uart {
 public:
  /// `send` is called with each byte at the end of its stop bit.
  Uart(Chip& chip, std::function<void(Cycles, uint8_t)> send);

  /// A start bit comes in.
  void begin_byte() { full_at_start_ = received_.size() == buffered; }
  /// Its stop bit has come in.
  void end_byte(uint8_t byte);
  unsigned overruns() const { return overruns_; }

 private:
  static constexpr std::size_t buffered = 3;
  struct Received {
    uint8_t byte;
    bool framing_error;
  };

  Cycles bit() const;
  bool matches_line() const;
  void write_status(uint8_t value);
  void write_control(uint8_t value);
  uint8_t read_status();
  uint8_t read_data();
  void write_data(uint8_t value);
  void shift_out(uint8_t value, Cycles when);
  void shifted_out(Cycles when);
  void cut_short();
  void reset();

  Chip& chip_;
  avr_uart_t& part_;
  std::function<void(Cycles, uint8_t)> send_;
  Alarm shifted_;
  std::deque<Received> received_;
  Cycles shift_bit_ = 1;
  uint8_t shift_ = 0, buffer_ = 0, last_read_ = 0;
  bool buffer_full_ = false, full_at_start_ = false, overrun_ = false;
  unsigned overruns_ = 0;
};

}  // namespace bench
