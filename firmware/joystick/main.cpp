// The firmware of an Arduino Uno (ATmega328P, 16 MHz): the pins of docs/joystick-link.md around Joystick. Nothing here
// waits longer than a DAC takes to answer; the watchdog resets a chip that does not come round within 30 ms, and its
// pins float then: the enable line opens.
#include <avr/eeprom.h>
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <avr/wdt.h>
#include <util/delay.h>

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
  if (count == 0 || room() < count) return;
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
constexpr uint8_t started = 0x08, data_taken = 0x28, data_came = 0x50, last_came = 0x58;
constexpr uint8_t address_taken[] = {0x18, 0x40};  // to write, to read
constexpr uint16_t patience = 1000;                // turns of the loop: some 0.5 ms, a byte takes 0.1

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

bool begin_dac(uint8_t axis, bool reads) {
  const uint8_t address = static_cast<uint8_t>(dac_address[axis] << 1 | reads);
  return i2c(_BV(TWSTA), started) && i2c_byte(address, address_taken[reads]);
}

// A DAC that a reset of the chip cut off amid a byte holds SDA low until it has been clocked to the byte's end.
void free_bus() {
  TWCR = 0;
  for (uint8_t i = 0; i < 9 && !(PINC & _BV(PC4)); ++i) {
    DDRC |= _BV(PC5);
    _delay_us(5);
    DDRC &= ~_BV(PC5);
    _delay_us(5);
  }
}

bool end_dac(bool fine) {
  if (fine) TWCR = _BV(TWINT) | _BV(TWEN) | _BV(TWSTO);
  for (uint16_t i = 0; fine && (TWCR & _BV(TWSTO)); ++i) fine = i < patience;
  if (!fine) free_bus();
  return fine;
}

bool write_dac(uint8_t axis, const uint8_t* bytes, uint8_t count) {
  bool taken = begin_dac(axis, false);
  for (uint8_t i = 0; taken && i < count; ++i) taken = i2c_byte(bytes[i], data_taken);
  return end_dac(taken);
}

bool read_dac(uint8_t axis, uint8_t* bytes, uint8_t count) {
  bool came = begin_dac(axis, true);
  for (uint8_t i = 0; came && i < count; ++i) {
    const bool last = i + 1 == count;
    came = i2c(last ? 0 : _BV(TWEA), last ? last_came : data_came);
    bytes[i] = TWDR;
  }
  return end_dac(came);
}

bool set_dac(uint8_t axis, uint16_t code) {
  const uint8_t bytes[] = {static_cast<uint8_t>(code >> 8), static_cast<uint8_t>(code & 0xFF)};
  return write_dac(axis, bytes, 2);
}

// -- what a DAC gives from power-up on: its own memory holds the neutral voltage -----------------------------------

constexpr uint8_t most_attempts = 3;  // at writing it: the memory wears out
uint8_t attempts[axes];
bool kept[axes];

void keep_anew() {
  for (uint8_t i = 0; i < axes; ++i) {
    kept[i] = false;
    attempts[i] = 0;
  }
}

enum class Memory : uint8_t { busy, right, wrong };

Memory look_into(uint8_t axis, uint16_t code) {
  uint8_t said[5];
  if (!read_dac(axis, said, sizeof said) || !(said[0] & 0x80)) return Memory::busy;
  const uint16_t word = static_cast<uint16_t>((said[3] & 0x6F) << 8 | said[4]);  // with its power-down mode
  return word == code ? Memory::right : Memory::wrong;
}

// While it writes into its memory, a DAC takes no codes: so it is done at neutral alone.
void keep_neutral(Joystick& joystick) {
  if (!is_neutral(joystick.given()) || !joystick.output().enabled) return;
  for (uint8_t i = 0; i < axes; ++i) {
    if (kept[i]) continue;
    const uint16_t code = joystick.output().code[i];
    const Memory memory = look_into(i, code);
    if (memory == Memory::busy) continue;
    kept[i] = memory == Memory::right || attempts[i] == most_attempts;
    if (kept[i]) joystick.dac_keeps(i, memory == Memory::right);
    if (kept[i]) continue;
    ++attempts[i];
    const uint8_t bytes[] = {0x60, static_cast<uint8_t>(code >> 4), static_cast<uint8_t>((code & 0x0F) << 4)};
    write_dac(i, bytes, sizeof bytes);
  }
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
  keep_anew();
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
  static bool answered[axes];
  const Output output = joystick.output();
  for (uint8_t i = 0; i < axes; ++i) {
    if (!refresh && output.code[i] == last[i]) continue;
    answered[i] = set_dac(i, output.code[i]);
    last[i] = output.code[i];
  }
  joystick.dac_answered(answered[0] && answered[1]);
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
  joystick.look(read_pins(0));  // an emergency keeps the relay open from the start
  drive(joystick, true);
  start_clock();
  start_serial();
  start_encoders();
  sei();
  uint32_t watched = 0, looked = 0;
  uint8_t wire[most_wire];
  for (;;) {
    take_bytes(joystick);
    const uint32_t now = untorn(milliseconds);
    if (now != watched) joystick.watch(watched = now);
    const bool due = now - looked >= report_ms;
    if (due) joystick.look(read_pins(looked = now));
    drive(joystick, due);
    if (due) keep_neutral(joystick);
    if (due) send(wire, joystick.report(now, wire));
    if (due) wdt_reset();  // a clock that stands still, with commands that do not age, is a loop that hangs
    const Calibration* changed = joystick.to_store();
    if (changed != nullptr) store(*changed);
    write_on();
    if (to_write == 0) send(wire, joystick.identity(wire));  // what it says of a calibration is stored
    sleep_mode();                                            // until the next byte, edge or millisecond
  }
}
