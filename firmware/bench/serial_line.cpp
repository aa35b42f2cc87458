#include "serial_line.hpp"

namespace bench {

namespace {

// 10 bits at 115200 baud are 16e6 * 10 / 115200 = 12500 / 9 cycles.
Cycles length(Cycles bytes) { return (bytes * 12500 + 4) / 9; }

}  // namespace

SerialLine::SerialLine(Chip& chip, std::function<void(Cycles, uint8_t)> receive)
    : uart_(chip,
            [this](Cycles when, uint8_t byte) {
              if (cut_) return void(++cut_off_);
              ++to_pc_;
              receive_(when, byte);
            }),
      receive_(std::move(receive)),
      chip_(chip),
      stop_bit_(chip, [this](Cycles) { end_byte(); }) {}

void SerialLine::send(uint8_t byte) {
  waiting_.push_back(byte);
  if (stop_bit_.is_set()) return;
  burst_ = chip_.now();
  in_burst_ = 0;
  begin_byte();
}

void SerialLine::begin_byte() {
  uart_.begin_byte();
  stop_bit_.set(burst_ + length(++in_burst_));
}

void SerialLine::end_byte() {
  const uint8_t byte = waiting_.front();
  waiting_.pop_front();
  ++(cut_ ? cut_off_ : from_pc_);
  if (!cut_) uart_.end_byte(byte);
  if (!waiting_.empty()) begin_byte();
}

}  // namespace bench
