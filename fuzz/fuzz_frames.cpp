// Any bytes on the joystick's line, to the chip and to the PC: raw, and in frames that are right. Whatever is said, the
// chip's outputs stay between the calibrated ends and are neutral unless it drives.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "../firmware/joystick/joystick.hpp"
#include "lfdcore/hardware/joystick_session.hpp"
#include "require_true.hpp"

namespace {

using namespace lfdcore;
using namespace lfdcore::joystick;

const Calibration usual = {
    {{200, 512, 824, 20}, {824, 512, 200, 20}}, {{1000, 2048, 3096}, {3096, 2048, 1000}}, {100, 50, 25, 10}};
constexpr FrameType types[] = {FrameType::command,        FrameType::query,  FrameType::set_calibration,
                               FrameType::select_profile, FrameType::report, FrameType::identity};

// What is taken for a frame is what would be sent for it, to the byte.
void check_reader(const std::uint8_t* data, std::size_t size) {
  FrameReader reader;
  std::vector<std::uint8_t> since;
  for (std::size_t i = 0; i < size; ++i) {
    Decoded outcome;
    Frame frame;
    since.push_back(data[i]);
    if (!reader.take(data[i], outcome, frame)) {
      if (data[i] == 0) since.clear();
      continue;
    }
    std::uint8_t wire[most_wire];
    if (outcome == Decoded::frame) {
      const std::size_t count = encode_frame(frame.type, frame.sequence, frame.payload, wire);
      require_true(std::equal(since.begin(), since.end(), wire, wire + count), "a frame is sent as it was read");
    }
    since.clear();
  }
}

// The input, a byte after the other; 0 at its end.
class Script {
 public:
  Script(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}
  bool ended() const { return left_ == 0; }
  std::uint8_t next() { return left_ == 0 ? 0 : (--left_, *data_++); }

 private:
  const std::uint8_t* data_;
  std::size_t left_;
};

// A chip and a PC that hear what the script says, frames and noise, while time passes.
class Both {
 public:
  explicit Both(Script script) : script_(script), chip_(script_.next() % 4 == 0 ? nullptr : &usual) {}

  void play() {
    while (!script_.ended()) {
      step();
      check_chip();
      check_pc();
    }
  }

 private:
  void step() {
    switch (script_.next() % 6) {
      case 0:
        return say(types[script_.next() % std::size(types)]);
      case 1:
        return say_command();
      case 2:
        return hear(script_.next());
      case 3:
        for (auto& count : pins_.adc) count = static_cast<std::uint16_t>(4 * script_.next());
        return;
      case 4:
        pins_.emergency = script_.next() % 2 != 0;
        return chip_.dac_answered(script_.next() % 8 != 0);
      default:
        return pass(script_.next());
    }
  }

  void hear(std::uint8_t byte) {
    chip_.take(byte, pins_.now);
    session_.take(&byte, 1, pins_.now / 1000.0);
  }

  void send(FrameType type, const std::uint8_t* payload) {
    std::uint8_t wire[most_wire];
    const std::size_t count = encode_frame(type, sequence_++, payload, wire);
    require_true(count <= most_wire, "a frame fits");
    for (std::size_t i = 0; i < count; ++i) hear(wire[i]);
  }

  void say(FrameType type) {
    std::uint8_t payload[most_payload];
    for (std::size_t i = 0; i < payload_bytes(static_cast<std::uint8_t>(type)); ++i) payload[i] = script_.next();
    send(type, payload);
  }

  // In answer to a report of up to 255 ms ago.
  void say_command() {
    std::uint8_t payload[most_payload];
    Writer writer(payload);
    writer.u32(pins_.now - script_.next());
    for (int axis = 0; axis < 2; ++axis) writer.i16(static_cast<std::int16_t>(script_.next() * 100 - 12800));
    send(FrameType::command, payload);
  }

  void pass(std::uint8_t ms) {
    for (int i = 0; i <= ms; ++i) {
      chip_.watch(++pins_.now);
      if (pins_.now % report_ms == 0) chip_.look(pins_);
      if (const Calibration* stored = chip_.to_store()) require_true(is_sound(*stored), "what is stored is sound");
    }
    std::uint8_t wire[most_wire];
    const std::size_t count = chip_.report(pins_.now, wire);
    session_.take(wire, count, pins_.now / 1000.0);
    session_.watch(pins_.now / 1000.0);
    chip_.identity(wire);
  }

  void check_chip() {
    const Axes given = chip_.given();
    require_true(is_in_range(given), "the output is in range");
    require_true(chip_.state() == State::driving || is_neutral(given), "neutral unless driving");
    for (const std::uint16_t code : chip_.output().code) require_true(code <= dac_top, "a DAC's code");
  }

  void check_pc() {
    const auto& said = session_.newest();
    if (!said) return;
    for (const double value : {said->forward, said->left, said->given_forward, said->given_left})
      require_true(std::abs(value) <= 1, "a reading is in range");
  }

  Script script_;
  Joystick chip_;
  JoystickSession session_;
  Reading pins_ = {0xFFFFFF00, {512, 512}, {0, 0}, 0, false, false};
  std::uint8_t sequence_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  check_reader(data, size);
  Both(Script(data, size)).play();
  return 0;
}
