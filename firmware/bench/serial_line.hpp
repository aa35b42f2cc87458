// The PC's end of the serial cable: 115200 baud, 8N1, byte after byte.
#pragma once

#include <deque>

#include "chip.hpp"
#include "uart.hpp"

namespace bench {

class SerialLine {
 public:
  /// `receive` is called with each byte of the chip, at the end of its stop bit.
  SerialLine(Chip& chip, std::function<void(Cycles, uint8_t)> receive);

  /// Begins now, or after what is still to be sent.
  void send(uint8_t byte);
  std::size_t waiting() const { return waiting_.size(); }
  void cut(bool cut) { cut_ = cut; }

  unsigned to_pc() const { return to_pc_; }
  unsigned from_pc() const { return from_pc_; }
  unsigned cut_off() const { return cut_off_; }
  const Uart& uart() const { return uart_; }

 private:
  void begin_byte();
  void end_byte();

  Uart uart_;
  std::function<void(Cycles, uint8_t)> receive_;
  Chip& chip_;
  Alarm stop_bit_;
  std::deque<uint8_t> waiting_;
  Cycles burst_ = 0, in_burst_ = 0;
  bool cut_ = false;
  unsigned to_pc_ = 0, from_pc_ = 0, cut_off_ = 0;
};

}  // namespace bench
