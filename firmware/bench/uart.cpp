#include "uart.hpp"

#include <algorithm>
#include <cmath>

#include "registers.hpp"

namespace bench {

namespace {

constexpr double line_baud = 115200;
constexpr double largest_baud_error = 0.025;  // an Uno at 115200 has 2.1 %; the next divisor, 3.5 %, fails on some PCs
constexpr uint8_t format_8n = 0x06, two_stop_bits = 0x08;
constexpr int bits_per_byte = 10;

}  // namespace

Uart::Uart(Chip& chip, std::function<void(Cycles, uint8_t)> send)
    : chip_(chip),
      part_(chip.part<avr_uart_t>("uart")),
      send_(std::move(send)),
      shifted_(chip, [this](Cycles when) { shifted_out(when); }) {
  chip.on_read(UCSR0A, [this] { return read_status(); });
  chip.on_read(UDR0, [this] { return read_data(); });
  chip.on_write(UCSR0A, [this](uint8_t value) { write_status(value); });
  chip.on_write(UCSR0B, [this](uint8_t value) { write_control(value); });
  chip.on_write(UDR0, [this](uint8_t value) { write_data(value); });
  chip.on_write(UBRR0L, [this](uint8_t value) { chip_.at(UBRR0L) = value; });
  chip.keep_raised(part_.rxc, [this] { return !received_.empty(); });
  chip.keep_raised(part_.udrc, [this] { return (chip_.at(UCSR0A) & UDRE0) != 0; });
  chip.on_reset([this] { reset(); });
}

Cycles Uart::bit() const {
  const Cycles divisor = 1 + chip_.at(UBRR0L) + 256 * (chip_.at(UBRR0H) & 15);
  return divisor * (chip_.at(UCSR0A) & U2X0 ? 8 : 16);
}

bool Uart::matches_line() const {
  const double baud = 1e6 * cycles_per_us / static_cast<double>(bit());
  return std::abs(baud / line_baud - 1) < largest_baud_error && (chip_.at(UCSR0C) & ~two_stop_bits) == format_8n;
}

void Uart::reset() {
  if (shifted_.is_set()) cut_short();
  received_.clear();
  buffer_full_ = overrun_ = false;
  chip_.at(UCSR0A) = UDRE0;
  chip_.at(UCSR0B) = 0;
  chip_.at(UCSR0C) = format_8n;
}

// The line goes high within a byte: the bits that were not sent yet are read as ones.
void Uart::cut_short() {
  const Cycles begun = shifted_.when() - bits_per_byte * shift_bit_;
  const Cycles sent = (chip_.now() - std::min(begun, chip_.now())) / shift_bit_;
  shifted_.cancel();
  if (sent > 0) send_(chip_.now(), static_cast<uint8_t>(shift_ | (0xFF << std::min<Cycles>(sent - 1, 8))));
}

void Uart::write_status(uint8_t value) {
  if (value & TXC0) chip_.lower(part_.txc);
  constexpr uint8_t writable = U2X0 | 1;
  chip_.at(UCSR0A) = static_cast<uint8_t>((chip_.at(UCSR0A) & ~writable) | (value & writable));
}

void Uart::write_control(uint8_t value) {
  chip_.at(UCSR0B) = value;
  if (!(value & RXEN0)) {
    received_.clear();
    chip_.lower(part_.rxc);
  }
  const uint8_t status = chip_.at(UCSR0A);
  if (value & RXCIE0 && status & RXC0) chip_.raise(part_.rxc);
  if (value & TXCIE0 && status & TXC0) chip_.raise(part_.txc);
  if (value & UDRIE0 && status & UDRE0) chip_.raise(part_.udrc);
}

uint8_t Uart::read_status() {
  const bool framing_error = !received_.empty() && received_.front().framing_error;
  const int errors = (framing_error ? FE0 : 0) | (overrun_ ? DOR0 : 0);
  return static_cast<uint8_t>((chip_.at(UCSR0A) & ~(FE0 | DOR0)) | errors);
}

uint8_t Uart::read_data() {
  if (received_.empty()) return last_read_;
  last_read_ = received_.front().byte;
  received_.pop_front();
  overrun_ = false;
  if (received_.empty()) chip_.lower(part_.rxc);
  return last_read_;
}

void Uart::end_byte(uint8_t byte) {
  if (!chip_.running() || !(chip_.at(UCSR0B) & RXEN0)) return;
  if (full_at_start_) {
    overrun_ = true;
    ++overruns_;
    return;
  }
  const bool good = matches_line();
  received_.push_back({good ? byte : static_cast<uint8_t>(~byte), !good});
  chip_.raise(part_.rxc);
}

void Uart::write_data(uint8_t value) {
  if (!(chip_.at(UCSR0B) & TXEN0) || !(chip_.at(UCSR0A) & UDRE0)) return;
  if (!shifted_.is_set()) return shift_out(value, chip_.now());
  buffer_ = value;
  buffer_full_ = true;
  chip_.lower(part_.udrc);
}

void Uart::shift_out(uint8_t value, Cycles when) {
  shift_ = matches_line() ? value : static_cast<uint8_t>(~value);
  shift_bit_ = bit();
  shifted_.set(when + bits_per_byte * shift_bit_);
}

void Uart::shifted_out(Cycles when) {
  send_(when, shift_);
  if (!buffer_full_) return chip_.raise(part_.txc);
  buffer_full_ = false;
  shift_out(buffer_, when);
  chip_.raise(part_.udrc);
}

}  // namespace bench
