// A firmware that tests the bench: it echoes its UART, and does what commands after an ESC say.
//
//   ESC a             -> both ADC codes, ESC e -> both edge counts; little-endian uint16, int32
//   ESC d FF FF LL LL    fast write to both DACs, big-endian -> the last TWI status of each
//   ESC p HH LL          forward DAC and its EEPROM -> the last TWI status
//   ESC q             -> five bytes read from the forward DAC
//   ESC n, ESC f         enable line on, off
//   ESC w                the watchdog is no longer reset
//   ESC s AA VV          EEPROM byte AA = VV -> AA; ESC r AA -> the byte
//   ESC m             -> MCUSR as it was at the start; ESC i -> PIND
//   ESC c                nine clocks on SCL as a port pin, to free the bus
#include <avr/eeprom.h>
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <avr/wdt.h>
#include <util/delay.h>
#include <util/twi.h>

namespace {

constexpr uint8_t escape = 0x1B;
constexpr uint8_t dac_address[] = {0x62, 0x63};

uint8_t reset_flags;
bool kicks_watchdog = true;
volatile int32_t edges[2];

// Both buffers hold 256 bytes: their indices run over by themselves.
struct Ring {
  volatile uint8_t bytes[256];
  volatile uint8_t first, last;
  bool empty() const { return first == last; }
  void push(uint8_t byte) { bytes[last++] = byte; }
  uint8_t pop() { return bytes[first++]; }
} received, sent;

void send(uint8_t byte) {
  while (static_cast<uint8_t>(sent.last + 1) == sent.first) wdt_reset();
  sent.push(byte);
  UCSR0B |= _BV(UDRIE0);
}

uint8_t receive() {
  while (received.empty())
    if (kicks_watchdog) wdt_reset();
  return received.pop();
}

void send_bytes(const void* data, uint8_t count) {
  for (uint8_t k = 0; k < count; ++k) send(static_cast<const uint8_t*>(data)[k]);
}

uint16_t adc(uint8_t channel) {
  ADMUX = _BV(REFS0) | channel;
  ADCSRA = _BV(ADEN) | _BV(ADSC) | 7;
  while (ADCSRA & _BV(ADSC)) {
  }
  return ADC;
}

// -> TWI status, or 0 where the bus did not answer within 1 ms
uint8_t twi(uint8_t control) {
  TWCR = _BV(TWEN) | _BV(TWINT) | control;
  for (uint8_t tries = 0; tries < 100; ++tries) {
    if (TWCR & _BV(TWINT)) return TW_STATUS;
    _delay_us(10);
  }
  TWCR = 0;
  return 0;
}

uint8_t twi_write(uint8_t address, const uint8_t* bytes, uint8_t count) {
  uint8_t status = twi(_BV(TWSTA));
  if (status != TW_START) return status;
  TWDR = static_cast<uint8_t>(address << 1);
  status = twi(0);
  for (uint8_t k = 0; k < count && (status == TW_MT_SLA_ACK || status == TW_MT_DATA_ACK); ++k) {
    TWDR = bytes[k];
    status = twi(0);
  }
  TWCR = _BV(TWEN) | _BV(TWINT) | _BV(TWSTO);
  return status;
}

void send_dac_reading() {
  twi(_BV(TWSTA));
  TWDR = dac_address[0] << 1 | 1;
  twi(0);
  for (uint8_t k = 0; k < 5; ++k) {
    twi(k < 4 ? _BV(TWEA) : 0);
    send(TWDR);
  }
  TWCR = _BV(TWEN) | _BV(TWINT) | _BV(TWSTO);
}

void write_dacs() {
  for (uint8_t k = 0; k < 2; ++k) {
    const uint8_t high = receive(), bytes[] = {high, receive()};
    send(twi_write(dac_address[k], bytes, 2));
  }
}

void store_in_dac() {
  const uint8_t high = receive(), low = receive();
  const uint8_t bytes[] = {0x60, static_cast<uint8_t>(high << 4 | low >> 4), static_cast<uint8_t>(low << 4)};
  send(twi_write(dac_address[0], bytes, 3));
}

void clock_bus() {
  TWCR = 0;
  for (uint8_t k = 0; k < 9; ++k) {
    DDRC |= _BV(PC5);
    _delay_us(5);
    DDRC &= ~_BV(PC5);
    _delay_us(5);
  }
}

void store_byte() {
  const uint8_t address = receive();
  eeprom_update_byte(reinterpret_cast<uint8_t*>(address), receive());
  eeprom_busy_wait();
  send(address);
}

void send_edges() {
  cli();
  const int32_t counts[] = {edges[0], edges[1]};
  sei();
  send_bytes(counts, sizeof counts);
}

void obey(uint8_t command) {
  const uint16_t codes[] = {adc(0), adc(1)};
  switch (command) {
    case 'a':
      return send_bytes(codes, sizeof codes);
    case 'e':
      return send_edges();
    case 'd':
      return write_dacs();
    case 'p':
      return store_in_dac();
    case 'q':
      return send_dac_reading();
    case 'n':
      PORTB |= _BV(PB0);
      return;
    case 'f':
      PORTB &= ~_BV(PB0);
      return;
    case 'w':
      kicks_watchdog = false;
      return;
    case 's':
      return store_byte();
    case 'r':
      return send(eeprom_read_byte(reinterpret_cast<uint8_t*>(receive())));
    case 'm':
      return send(reset_flags);
    case 'i':
      return send(PIND);
    case 'c':
      return clock_bus();
    default:
      return;
  }
}

void set_up() {
  UBRR0 = 16;
  UCSR0A = _BV(U2X0);
  UCSR0B = _BV(RXEN0) | _BV(TXEN0) | _BV(RXCIE0);
  TWBR = 12;  // 400 kHz
  DDRB = _BV(PB0);
  PORTD = _BV(PD6) | _BV(PD7);
  PCMSK2 = 0x3C;
  PCICR = _BV(PCIE2);
  wdt_enable(WDTO_250MS);
  sei();
}

}  // namespace

ISR(USART_RX_vect) { received.push(UDR0); }

ISR(USART_UDRE_vect) {
  if (sent.empty())
    UCSR0B &= ~_BV(UDRIE0);
  else
    UDR0 = sent.pop();
}

ISR(PCINT2_vect) {
  static uint8_t before;
  static const int8_t steps[] = {0, 1, -1, 0, -1, 0, 0, 1, 1, 0, 0, -1, 0, -1, 1, 0};  // [before B A, now B A]
  const uint8_t now = PIND >> 2 & 15;
  edges[0] += steps[(before & 3) << 2 | (now & 3)];
  edges[1] += steps[(before & 12) | now >> 2];
  before = now;
}

int main() {
  reset_flags = MCUSR;
  MCUSR = 0;
  set_up();
  for (;;) {
    const uint8_t byte = receive();
    if (byte == escape)
      obey(receive());
    else
      send(byte);
  }
}
