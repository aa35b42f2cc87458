#include "bench.hpp"

#include <cstdio>
#include <sstream>

#include "registers.hpp"

namespace bench {

namespace {

// Pins of port D.
constexpr unsigned left_a = 2, left_b = 3, right_a = 4, right_b = 5, manual_pin = 6, emergency_pin = 7;
constexpr uint8_t forward_address = 0x62, left_address = 0x63;

// Writes "a": 1, "b": 2, ... without the braces.
class Fields {
 public:
  template <typename Value>
  Fields& add(const char* name, const Value& value) {
    text_ << (empty_ ? "" : ", ") << '"' << name << "\": " << value;
    empty_ = false;
    return *this;
  }
  template <typename Value>
  Fields& add(const char* name, const Value& first, const Value& second) {
    std::ostringstream pair;
    pair << '[' << first << ", " << second << ']';
    return add(name, pair.str());
  }
  std::string object() const { return std::string("{").append(text_.str()).append("}"); }

 private:
  std::ostringstream text_;
  bool empty_ = true;
};

const char* json(bool value) { return value ? "true" : "false"; }

std::string resets_of(const Chip& chip) {
  Fields fields;
  for (const Reset cause : {Reset::power, Reset::external, Reset::brown_out, Reset::watchdog})
    fields.add(name_of(cause), chip.resets(cause));
  return fields.object();
}

std::string uart_of(const SerialLine& line) {
  return Fields()
      .add("from_pc", line.from_pc())
      .add("to_pc", line.to_pc())
      .add("overrun", line.uart().overruns())
      .add("cut_off", line.cut_off())
      .object();
}

std::string pins_of(const InputPins& inputs) {
  constexpr const char* names[] = {"left_a", "left_b", "right_a", "right_b", "manual", "emergency"};
  Fields fields;
  for (unsigned pin = left_a; pin <= emergency_pin; ++pin) fields.add(names[pin - left_a], inputs.high(pin) ? 1 : 0);
  return fields.object();
}

}  // namespace

std::string microseconds(Cycles when) {
  char text[40];
  std::snprintf(text, sizeof text, "%llu.%04u", static_cast<unsigned long long>(when / cycles_per_us),
                static_cast<unsigned>(when % cycles_per_us * 10000 / cycles_per_us));
  return text;
}

Bench::Bench(const std::string& elf, const std::string& eeprom_file, std::function<void(Cycles, uint8_t)> received,
             std::function<void(Cycles, const std::string&)> event)
    : chip(elf),
      event_(std::move(event)),
      forward_dac_(chip, forward_address,
                   [this](Cycles when) { event_(when, "dac0 " + std::to_string(forward_dac_.output())); }),
      left_dac_(chip, left_address,
                [this](Cycles when) { event_(when, "dac1 " + std::to_string(left_dac_.output())); }),
      eeprom(chip, eeprom_file),
      adc(chip,
          [this](std::size_t channel, unsigned code) {
            event_(chip.now(), "adc" + std::to_string(channel) + ' ' + std::to_string(code));
          }),
      line(chip, std::move(received)),
      twi(chip, {{forward_dac_}, {left_dac_}}),
      inputs(chip),
      left_encoder(chip, inputs, left_a, left_b),
      right_encoder(chip, inputs, right_a, right_b),
      manual(inputs, manual_pin, false),
      emergency(inputs, emergency_pin, true),
      enable(chip, [this](Cycles when) { event_(when, enable.high() ? "enable 1" : "enable 0"); }) {
  chip.on_reset_begin([this](Reset cause) { event_(chip.now(), std::string("reset ") + name_of(cause)); });
  chip.reset(Reset::power);
}

void Bench::power(bool on) {
  if (on == chip.powered()) return;
  on ? chip.power_on() : chip.power_off();
  forward_dac_.set_powered(on);
  left_dac_.set_powered(on);
  if (!on) event_(chip.now(), "power 0");
}

std::string Bench::state() const {
  return Fields()
      .add("time_us", microseconds(chip.now()))
      .add("powered", json(chip.powered()))
      .add("running", json(chip.running()))
      .add("dac", forward_dac_.output(), left_dac_.output())
      .add("dac_time_us", microseconds(forward_dac_.written()), microseconds(left_dac_.written()))
      .add("dac_writes", forward_dac_.writes(), left_dac_.writes())
      .add("dac_ignored", forward_dac_.ignored(), left_dac_.ignored())
      .add("dac_eeprom", forward_dac_.eeprom(), left_dac_.eeprom())
      .add("enable", enable.high() ? 1 : 0)
      .add("enable_time_us", microseconds(enable.changed()))
      .add("adc_mv", adc.millivolts(0), adc.millivolts(1))
      .add("edges", left_encoder.edges(), right_encoder.edges())
      .add("pins", pins_of(inputs))
      .add("resets", resets_of(chip))
      .add("crashes", chip.crashes())
      .add("uart", uart_of(line))
      .object();
}

}  // namespace bench
