// Addresses and bits of the ATmega328P's registers, as its datasheet names them.
#pragma once

#include <cstdint>

namespace bench {

enum Register : uint16_t {
  PINB = 0x23,
  DDRB = 0x24,
  PORTB = 0x25,
  PINC = 0x26,
  DDRC = 0x27,
  PORTC = 0x28,
  PIND = 0x29,
  DDRD = 0x2A,
  PORTD = 0x2B,
  EECR = 0x3F,
  EEDR = 0x40,
  EEARL = 0x41,
  EEARH = 0x42,
  MCUSR = 0x54,
  MCUCR = 0x55,
  ADCL = 0x78,
  ADCH = 0x79,
  ADCSRA = 0x7A,
  ADMUX = 0x7C,
  TWBR = 0xB8,
  TWSR = 0xB9,
  TWDR = 0xBB,
  TWCR = 0xBC,
  UCSR0A = 0xC0,
  UCSR0B = 0xC1,
  UCSR0C = 0xC2,
  UBRR0L = 0xC4,
  UBRR0H = 0xC5,
  UDR0 = 0xC6,
};

constexpr uint8_t PUD = 1 << 4;                                                        // MCUCR
constexpr uint8_t PORF = 1, EXTRF = 2, BORF = 4, WDRF = 8;                             // MCUSR
constexpr uint8_t EERE = 1, EEPE = 2, EEMPE = 4, EERIE = 8, EEPM0 = 16, EEPM1 = 32;    // EECR
constexpr uint8_t ADSC = 1 << 6;                                                       // ADCSRA
constexpr uint8_t ADLAR = 1 << 5;                                                      // ADMUX
constexpr uint8_t TWIE = 1, TWEN = 4, TWSTO = 16, TWSTA = 32, TWEA = 64, TWINT = 128;  // TWCR
constexpr uint8_t U2X0 = 2, DOR0 = 8, FE0 = 16, UDRE0 = 32, TXC0 = 64, RXC0 = 128;     // UCSR0A
constexpr uint8_t TXEN0 = 8, RXEN0 = 16, UDRIE0 = 32, TXCIE0 = 64, RXCIE0 = 128;       // UCSR0B

}  // namespace bench
