// The firmware of an Arduino Uno (ATmega328P, 16 MHz): the pins of docs/joystick-link.md around Joystick. Nothing here
// waits longer than a DAC takes to answer; the watchdog resets a chip that does not come round within 30 ms, and its
// pins float then: the enable line opens.
#include <avr/eeprom.h>
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <avr/wdt.h>

#include "joystick.hpp"

using namespace lfdcore::joystick;

namespace {

// -- time: 1 ms ----------------------------------------------------------------------------------------------------

volatile uint32_t milliseconds = 0;

void start_clock() {
  TCCR0A = _BV(WGM01);  // clear at OCR0A
  TCCR0B = _BV(CS01) | _BV(CS00);
  OCR0A = F_CPU / 64 / 1000 - 1;
  TIMSK0 = _BV(OCIE0A);
}

template <class T>
T untorn(const volatile T& value) {
  const uint8_t before = SREG;
  cli();
  const T copy = value;
  SREG = before;
  return copy;
}

// -- serial: 115200 baud -------------------------------------------------------------------------------------------

constexpr uint8_t ring = 128;  // a power of two
volatile uint8_t received[ring], sent[ring];
volatile uint8_t received_in = 0, received_out = 0, sent_in = 0, sent_out = 0;

void start_serial() {
  UCSR0A = _BV(U2X0);
  UBRR0 = F_CPU / 8 / 115200 - 1;  // 16: 2.1 % fast; one more would be 3.5 % slow
  UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
  UCSR0B = _BV(RXEN0) | _BV(TXEN0) | _BV(RXCIE0);
}

uint8_t room() { return static_cast<uint8_t>(ring - 1 - ((sent_in - sent_out) & (ring - 1))); }

// A frame goes out whole or not at all.
void send(const uint8_t* bytes, size_t count) {
  if (room() < count) return;
  for (size_t i = 0; i < count; ++i) {
    sent[sent_in] = bytes[i];
    sent_in = (sent_in + 1) & (ring - 1);
  }
  UCSR0B |= _BV(UDRIE0);
}

// -- encoders: D2 to D5, both lines of both wheels -----------------------------------------------------------------

volatile int32_t edges[axes] = {0, 0};
volatile uint16_t lost_edges = 0;
volatile uint8_t lines = 0;

// From the old two lines (high bits) and the new: one step ahead, one back, none; 2: both changed, one edge was lost.
constexpr int8_t steps[16] = {0, 1, -1, 2, -1, 0, 2, 1, 1, 2, 0, -1, 2, -1, 1, 0};

void count_edges(uint8_t wheel, uint8_t before, uint8_t now) {
  const int8_t step = steps[(before << 2) | now];
  if (step == 2)
    ++lost_edges;
  else
    edges[wheel] += step;
}

void start_encoders() {
  PORTD |= _BV(PD2) | _BV(PD3) | _BV(PD4) | _BV(PD5);  // pull-ups
  lines = (PIND >> 2) & 0x0F;
  PCMSK2 = _BV(PCINT18) | _BV(PCINT19) | _BV(PCINT20) | _BV(PCINT21);
  PCICR = _BV(PCIE2);
}

// -- stick, buttons, enable line -----------------------------------------------------------------------------------

void start_pins() {
  PORTB &= ~_BV(PB0);  // enable: open
  DDRB |= _BV(PB0);
  PORTD |= _BV(PD6) | _BV(PD7);  // pull-ups: manual (pressed: low), emergency (low: fine)
  ADMUX = _BV(REFS0);
  ADCSRA = _BV(ADEN) | _BV(ADPS2) | _BV(ADPS1) | _BV(ADPS0);
}

uint16_t adc(uint8_t channel) {
  ADMUX = _BV(REFS0) | channel;
  ADCSRA |= _BV(ADSC);
  while (ADCSRA & _BV(ADSC)) {
  }
  return ADC;
}

Reading read_pins(uint32_t now) {
  Reading reading;
  reading.now = now;
  for (uint8_t i = 0; i < axes; ++i) reading.adc[i] = adc(i);
  for (uint8_t i = 0; i < axes; ++i) reading.edges[i] = untorn(edges[i]);
  reading.lost_edges = untorn(lost_edges);
  reading.manual = !(PIND & _BV(PD6));
  reading.emergency = PIND & _BV(PD7);
  return reading;
}

void enable(bool closed) {
  if (closed)
    PORTB |= _BV(PB0);
  else
    PORTB &= ~_BV(PB0);
}

// -- two MCP4725 on I2C, 100 kHz -----------------------------------------------------------------------------------

constexpr uint8_t dac_address[axes] = {0x62, 0x63};
constexpr uint8_t started = 0x08, address_taken = 0x18, data_taken = 0x28;
constexpr uint16_t patience = 1000;  // turns of the loop: some 0.5 ms, a byte takes 0.1

void start_i2c() { TWBR = (F_CPU / 100000 - 16) / 2; }

bool i2c(uint8_t control, uint8_t wanted) {
  TWCR = _BV(TWINT) | _BV(TWEN) | control;
  for (uint16_t i = 0; i < patience; ++i)
    if (TWCR & _BV(TWINT)) return (TWSR & 0xF8) == wanted;
  return false;
}

bool i2c_byte(uint8_t byte, uint8_t wanted) {
  TWDR = byte;
  return i2c(0, wanted);
}

bool write_dac(uint8_t axis, const uint8_t* bytes, uint8_t count) {
  bool taken = i2c(_BV(TWSTA), started) && i2c_byte(static_cast<uint8_t>(dac_address[axis] << 1), address_taken);
  for (uint8_t i = 0; taken && i < count; ++i) taken = i2c_byte(bytes[i], data_taken);
  TWCR = taken ? _BV(TWINT) | _BV(TWEN) | _BV(TWSTO) : 0;  // after a fault the bus is let go
  for (uint16_t i = 0; taken && (TWCR & _BV(TWSTO)); ++i)
    if (i >= patience) return false;
  return taken;
}

bool set_dac(uint8_t axis, uint16_t code) {
  const uint8_t bytes[] = {static_cast<uint8_t>(code >> 8), static_cast<uint8_t>(code & 0xFF)};
  return write_dac(axis, bytes, 2);
}

// What it gives from power-up on.
bool keep_in_dac(uint8_t axis, uint16_t code) {
  const uint8_t bytes[] = {0x60, static_cast<uint8_t>(code >> 4), static_cast<uint8_t>((code & 0x0F) << 4)};
  return write_dac(axis, bytes, 3);
}

// -- what is stored: the calibration and its CRC, byte by byte -----------------------------------------------------

constexpr uint8_t record_bytes = calibration_bytes + crc_bytes;
uint8_t record[record_bytes];
uint8_t to_write = 0;  // bytes of `record` that are not yet in the EEPROM, from its end

bool load(Calibration& calibration) {
  for (uint8_t i = 0; i < record_bytes; ++i) record[i] = eeprom_read_byte(reinterpret_cast<const uint8_t*>(i));
  calibration = read_calibration(record);
  return crc16(record, calibration_bytes) == Reader(record + calibration_bytes).u16();
}

void store(const Calibration& calibration) {
  write_calibration(calibration, record);
  Writer(record + calibration_bytes).u16(crc16(record, calibration_bytes));
  to_write = record_bytes;
  for (uint8_t i = 0; i < axes; ++i) keep_in_dac(i, calibration.output[i].neutral);
}

// A byte takes 3.4 ms: one at a time. The CRC is written first, so that what is cut off is not sound.
void write_on() {
  if (to_write == 0 || !eeprom_is_ready()) return;
  --to_write;
  eeprom_update_byte(reinterpret_cast<uint8_t*>(to_write), record[to_write]);
}

// -- the loop ------------------------------------------------------------------------------------------------------

void take_bytes(Joystick& joystick) {
  while (received_out != received_in) {
    joystick.take(received[received_out], untorn(milliseconds));
    received_out = (received_out + 1) & (ring - 1);
  }
}

// The DACs get what is new at once, and all of it again every 10 ms: a DAC that was reset knows it again.
void drive(Joystick& joystick, bool refresh) {
  static uint16_t last[axes];
  const Output output = joystick.output();
  bool answered = true, wrote = false;
  for (uint8_t i = 0; i < axes; ++i) {
    if (!refresh && output.code[i] == last[i]) continue;
    answered = set_dac(i, output.code[i]) && answered;
    last[i] = output.code[i];
    wrote = true;
  }
  if (wrote) joystick.dac_answered(answered);
  enable(joystick.output().enabled);
}

}  // namespace

ISR(TIMER0_COMPA_vect) { ++milliseconds; }

ISR(USART_RX_vect) {
  const uint8_t byte = UDR0, next_in = (received_in + 1) & (ring - 1);
  if (next_in == received_out) return;  // full: the frame's CRC will tell
  received[received_in] = byte;
  received_in = next_in;
}

ISR(USART_UDRE_vect) {
  if (sent_out == sent_in) {
    UCSR0B &= ~_BV(UDRIE0);
    return;
  }
  UDR0 = sent[sent_out];
  sent_out = (sent_out + 1) & (ring - 1);
}

ISR(PCINT2_vect) {
  const uint8_t now = (PIND >> 2) & 0x0F, before = lines;
  count_edges(0, before & 3, now & 3);
  count_edges(1, before >> 2, now >> 2);
  lines = now;
}

int main() {
  wdt_enable(WDTO_30MS);
  start_pins();
  start_i2c();
  Calibration stored;
  Joystick joystick(load(stored) ? &stored : nullptr);
  drive(joystick, true);
  start_clock();
  start_serial();
  start_encoders();
  sei();
  uint32_t watched = 0, looked = 0;
  uint8_t wire[most_wire];
  for (;;) {
    wdt_reset();
    take_bytes(joystick);
    const uint32_t now = untorn(milliseconds);
    if (now != watched) joystick.watch(watched = now);
    const bool due = now - looked >= report_ms;
    if (due) joystick.look(read_pins(looked = now));
    drive(joystick, due);
    if (due) send(wire, joystick.report(now, wire));
    const size_t count = joystick.identity(wire);
    if (count != 0) send(wire, count);
    const Calibration* changed = joystick.to_store();
    if (changed != nullptr) store(*changed);
    write_on();
    sleep_mode();  // until the next byte, edge or millisecond
  }
}
