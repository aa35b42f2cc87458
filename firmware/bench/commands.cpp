#include "commands.hpp"

#include <cmath>
#include <map>
#include <sstream>
#include <stdexcept>

namespace bench {

namespace {

constexpr double supply = 5000, fastest = 20000;

void set_adc(Bench& bench, const Words& words) {
  words.expect(3, "adc 0|1 MILLIVOLTS");
  const double millivolts = words.number(2, "MILLIVOLTS", 0, supply);
  bench.adc.set_millivolts(words.choice(1, "0", "1") ? 1 : 0, millivolts);
}

void set_wheels(Bench& bench, const Words& words) {
  words.expect(3, "wheels LEFT_EDGES_PER_S RIGHT_EDGES_PER_S");
  const double left = words.number(1, "LEFT_EDGES_PER_S", -fastest, fastest);
  const double right = words.number(2, "RIGHT_EDGES_PER_S", -fastest, fastest);
  bench.left_encoder.set_rate(left);
  bench.right_encoder.set_rate(right);
}

// The manual button closes its contact when pressed; the emergency button opens it.
void set_button(Bench& bench, const Words& words) {
  words.expect(3, "button manual|emergency 0|1");
  const bool emergency = words.choice(1, "manual", "emergency"), pressed = words.choice(2, "0", "1");
  (emergency ? bench.emergency : bench.manual).set_closed(pressed != emergency);
}

void set_wire(Bench& bench, const Words& words) {
  words.expect(3, "button_wire manual|emergency joined|broken");
  const bool emergency = words.choice(1, "manual", "emergency");
  (emergency ? bench.emergency : bench.manual).set_broken(words.choice(2, "joined", "broken"));
}

void set_bus(Bench& bench, const Words& words) {
  constexpr const char* usage = "i2c dac0|dac1 present|absent|stuck [CLOCKS]";
  const bool stuck = words.size() > 2 && words.word(2) == "stuck";
  words.expect(stuck && words.size() == 4 ? 4 : 3, usage);
  BusDac& dac = bench.twi.dac(words.choice(1, "dac0", "dac1") ? 1 : 0);
  const unsigned clocks = words.size() == 4 ? static_cast<unsigned>(words.number(3, "CLOCKS", 1, 1000)) : 0;
  if (!stuck) dac.absent = words.choice(2, "present", "absent");
  dac.stuck = stuck;
  dac.clocks = clocks;
  bench.twi.renew_pins();
}

void set_dac_eeprom(Bench& bench, const Words& words) {
  words.expect(4, "dac_eeprom dac0|dac1 CODE sound|worn");
  const double code = words.number(2, "CODE", 0, 4095);
  const bool worn = words.choice(3, "sound", "worn");
  bench.twi.dac(words.choice(1, "dac0", "dac1") ? 1 : 0).dac.set_eeprom(static_cast<unsigned>(code), worn);
}

void set_cable(Bench& bench, const Words& words) {
  words.expect(2, "uart cut|join");
  bench.line.cut(!words.choice(1, "cut", "join"));
}

void set_power(Bench& bench, const Words& words) {
  words.expect(2, "power off|on");
  bench.power(words.choice(1, "off", "on"));
}

void reset(Bench& bench, const Words& words) {
  words.expect(1, "reset");
  bench.chip.reset(Reset::external);
}

void brown_out(Bench& bench, const Words& words) {
  words.expect(1, "brownout");
  bench.chip.reset(Reset::brown_out);
}

void hang(Bench& bench, const Words& words) {
  words.expect(2, "hang all|main");
  bench.chip.hang(words.choice(1, "all", "main"));
}

using Command = void (*)(Bench&, const Words&);
const std::map<std::string, Command> commands = {
    {"adc", set_adc}, {"wheels", set_wheels},         {"button", set_button}, {"button_wire", set_wire},
    {"i2c", set_bus}, {"dac_eeprom", set_dac_eeprom}, {"uart", set_cable},    {"power", set_power},
    {"reset", reset}, {"brownout", brown_out},        {"hang", hang},
};

}  // namespace

const char* const command_help =
    R"(Commands, one a line on standard input; each has one answer, "ok", "error WHY" or JSON:
  adc 0|1 MILLIVOLTS                       the stick: 0 forward, 1 left; 0 to 5000
  wheels LEFT RIGHT                        edges a second, -20000 to 20000; both encoders turn from then on
  button manual|emergency 0|1              1: pressed
  button_wire manual|emergency joined|broken
  i2c dac0|dac1 present|absent|stuck [N]   absent: wires cut, its output stays; stuck: holds SDA low (until N clocks)
  dac_eeprom dac0|dac1 CODE sound|worn     what it gives at its next power-up; worn: it takes nothing else
  uart cut|join                            the serial cable
  usb unplug|plug                          without --free: the port vanishes; plugged again, its path is the answer
  power off|on                             off: RAM and the DACs' registers are lost
  reset                                    the reset button
  brownout                                 the supply fails for a moment: a reset; RAM and DACs stay
  hang all|main                            the program loops for ever; main: its interrupts are still served
  trace on|off                             event lines "@MICROSECONDS WHAT": changes of what the ADC reads, of DACs and enable line, resets
  get                                      everything, as JSON
  run MICROSECONDS                         with --free: time passes; answered when it has
  send HEX                                 with --free: bytes to the chip, from now on, without a gap
Times are of the chip's clock since it was first powered [us]. With --free the bytes of the chip come as event lines
"@MICROSECONDS uart HEX", each at the end of its stop bit; else they go over the pseudo-terminal.
)";

Words::Words(const std::string& line) {
  std::istringstream in(line);
  for (std::string word; in >> word;) words_.push_back(word);
}

void Words::expect(std::size_t count, const char* usage) const {
  if (words_.size() != count) throw std::invalid_argument(std::string("usage: ") + usage);
}

double Words::number(std::size_t index, const char* name, double least, double most) const {
  std::istringstream in(words_[index]);
  double value = 0;
  if (in >> value && in.eof() && value >= least && value <= most) return value;
  std::ostringstream text;
  text << name << " is '" << words_[index] << "', must be a number from " << least << " to " << most;
  throw std::invalid_argument(text.str());
}

bool Words::choice(std::size_t index, const char* no, const char* yes) const {
  if (words_[index] == yes) return true;
  if (words_[index] == no) return false;
  throw std::invalid_argument("'" + words_[index] + "' must be '" + no + "' or '" + yes + "'");
}

std::string carry_out(Bench& bench, const std::string& line) {
  const Words words(line);
  if (words.size() == 0) throw std::invalid_argument("an empty command");
  if (words.word(0) == "get") {
    words.expect(1, "get");
    return bench.state();
  }
  const auto found = commands.find(words.word(0));
  if (found == commands.end()) throw std::invalid_argument("unknown command '" + words.word(0) + "'");
  found->second(bench, words);
  return "ok";
}

}  // namespace bench
