// What the Arduino at the joystick does, without its pins (docs/joystick-link.md): readings of the stick and bytes from
// the PC in, DAC codes and bytes to the PC out. The host's tests run this very class.
#pragma once

#include "lfdcore/hardware/calibration.hpp"
#include "lfdcore/hardware/frame_codec.hpp"
#include "lfdcore/hardware/link_state.hpp"

namespace lfdcore {
namespace joystick {

constexpr uint8_t firmware_version = 1;

/// What the pins say, every `report_ms`.
struct Reading {
  uint32_t now;         ///< [ms] of the chip's clock
  uint16_t adc[axes];   ///< [counts]
  int32_t edges[axes];  ///< of the left and the right wheel's encoder; wraps around
  uint16_t lost_edges;  ///< both lines of an encoder changed at once; wraps around
  bool manual, emergency;
};

/// What the pins are to say.
struct Output {
  uint16_t code[axes];  ///< of the DACs
  bool enabled;         ///< the controller may listen to them
};

class Joystick {
 public:
  /// With what is stored: begins as `fault` without a sound calibration.
  explicit Joystick(const Calibration* stored) {
    if (stored != nullptr && is_sound(*stored))
      calibration_ = *stored;
    else
      faults_ = not_calibrated;
    if (faults_ != 0) happen(Event::fault_found);
  }

  /// Looks at the stick. To be called every `report_ms`; a report is due after it.
  void look(const Reading& reading) {
    reading_ = reading;
    watch(reading.now);
    if (calibrated()) read_stick();
    if (!is_neutral(stick_) || faults_ != 0) neutral_since_ = reading.now;
    if (reading.now - neutral_since_ >= neutral_ms) happen(Event::stick_neutral);
    happen(reading.emergency ? Event::emergency_pressed : Event::emergency_released);
    judge();
  }

  /// Looks at the age of the command. To be called every millisecond.
  void watch(uint32_t now) {
    if (has_command_ && now - command_tick_ > command_ms) has_command_ = false;
    if (!has_command_) happen(Event::command_old);
  }

  /// Takes a byte that came at `now` [ms].
  void take(uint8_t byte, uint32_t now) {
    Decoded outcome;
    Frame frame;
    if (!reader_.take(byte, outcome, frame)) return;
    if (outcome == Decoded::frame)
      obey(frame, now);
    else
      ++bad_frames_;
  }

  /// The DACs answered, or did not, when they were last given their codes.
  void dac_answered(bool answered) {
    set_fault(dac_failed, !answered);
    judge();
  }

  /// A DAC's own memory holds its neutral code, or does not take it.
  void dac_keeps(uint8_t axis, bool kept) {
    set_fault(axis == 0 ? forward_memory : left_memory, !kept);
    judge();
  }

  Output output() const {
    const bool enabled = calibrated() && !has(dac_failed) && state_ != State::emergency;
    const Axes value = given();
    return {{code_of(calibration_.output[0], value.forward), code_of(calibration_.output[1], value.left)}, enabled};
  }

  /// What the DACs are given, -full to full; 0 but while driving.
  Axes given() const {
    if (state_ != State::driving) return {0, 0};
    const Axes value = allowed(command_, stick_);
    const int32_t percent = calibration_.profile_percent[profile_];
    return {static_cast<int16_t>(value.forward * percent / 100), static_cast<int16_t>(value.left * percent / 100)};
  }

  /// Writes the report of the last look -> its bytes on the wire, most_wire at most.
  size_t report(uint32_t now, uint8_t* wire) {
    uint8_t payload[most_payload];
    Writer writer(payload);
    const Axes value = given();
    writer.u32(reading_.now);
    writer.i16(stick_.forward);
    writer.i16(stick_.left);
    for (uint8_t i = 0; i < axes; ++i) writer.u16(reading_.adc[i]);
    for (uint8_t i = 0; i < axes; ++i) writer.i32(reading_.edges[i]);
    writer.u16(reading_.lost_edges);
    writer.i16(value.forward);
    writer.i16(value.left);
    writer.u8(static_cast<uint8_t>(state_));
    writer.u16(faults_);
    writer.u8(static_cast<uint8_t>((reading_.manual ? 1 : 0) | (reading_.emergency ? 2 : 0)));
    writer.u8(profile_);
    writer.u8(command_age(now));
    writer.u16(bad_frames_);
    return encode_frame(FrameType::report, sequence_++, payload, wire);
  }

  /// Writes who this is -> its bytes on the wire. 0: nobody asked.
  size_t identity(uint8_t* wire) {
    if (!asked_) return 0;
    asked_ = false;
    uint8_t payload[most_payload];
    Writer writer(payload);
    writer.u8(firmware_version);
    writer.u8(calibrated() ? 1 : 0);
    writer.u16(0);
    write_calibration(calibration_, payload + 4);
    return encode_frame(FrameType::identity, sequence_++, payload, wire);
  }

  /// What is to be stored, once after each calibration that the PC set; null: nothing is.
  const Calibration* to_store() {
    if (!store_) return nullptr;
    store_ = false;
    return &calibration_;
  }

  State state() const { return state_; }
  uint16_t faults() const { return faults_; }
  const Axes& stick() const { return stick_; }

 private:
  bool has(Fault fault) const { return (faults_ & fault) != 0; }
  bool calibrated() const { return !has(not_calibrated); }
  void happen(Event event) { state_ = next(state_, event); }

  void set_fault(Fault fault, bool found) {
    faults_ = static_cast<uint16_t>(found ? faults_ | fault : faults_ & ~fault);
  }
  void judge() { happen(faults_ != 0 ? Event::fault_found : Event::fault_gone); }

  // A reading beyond the ends is none: the stick counts as let go. A wire that is broken now and then is broken.
  void read_stick() {
    int16_t value[axes];
    bool whole = true;
    for (uint8_t i = 0; i < axes; ++i) {
      const bool plausible = is_plausible(calibration_.axis[i], reading_.adc[i]);
      whole = whole && plausible;
      value[i] = plausible ? stick_of(calibration_.axis[i], reading_.adc[i]) : 0;
      judge_wire(i, plausible);
    }
    stick_ = {0, 0};
    if (whole && !has(forward_wire) && !has(left_wire)) stick_ = {value[0], value[1]};
  }

  void judge_wire(uint8_t axis, bool plausible) {
    uint8_t& doubt = doubt_[axis];
    if (plausible)
      doubt = doubt > 0 ? doubt - 1 : 0;
    else
      doubt = doubt + wire_weight < wire_doubt ? doubt + wire_weight : wire_doubt;
    const Fault wire = axis == 0 ? forward_wire : left_wire;
    if (doubt == wire_doubt) set_fault(wire, true);
    if (doubt == 0) set_fault(wire, false);
  }

  void obey(const Frame& frame, uint32_t now) {
    Reader reader(frame.payload);
    switch (frame.type) {
      case FrameType::command: {
        const uint32_t tick = reader.u32();
        const int16_t forward = reader.i16();
        return command(tick, {forward, reader.i16()}, now);
      }
      case FrameType::query:
        asked_ = true;
        return;
      case FrameType::set_calibration:
        return calibrate(read_calibration(frame.payload));
      case FrameType::select_profile:
        return select(reader.u8());
      default:
        ++bad_frames_;  // what a chip sends itself
    }
  }

  // It answers the report of `tick`: one from the future, from too long ago or before the last one is none.
  void command(uint32_t tick, const Axes& value, uint32_t now) {
    if (now - tick > command_ms || (has_command_ && command_tick_ - tick < command_ms && command_tick_ != tick)) return;
    set_fault(bad_command, !is_in_range(value));
    judge();
    if (has(bad_command)) return;
    command_ = value;
    command_tick_ = tick;
    has_command_ = true;
    happen(Event::command_fresh);
  }

  // What is not sound is not taken, nor anything while the chair moves; the identity tells.
  void calibrate(const Calibration& calibration) {
    asked_ = true;
    if (!is_sound(calibration) || !is_neutral(given())) return;
    calibration_ = calibration;
    store_ = true;
    set_fault(not_calibrated, false);
    settings_changed();
  }

  void select(uint8_t profile) {
    if (profile >= profiles || profile == profile_) return;
    profile_ = profile;
    settings_changed();
  }

  void settings_changed() {
    neutral_since_ = reading_.now;
    happen(Event::settings_changed);
    judge();
  }

  uint8_t command_age(uint32_t now) const {
    if (!has_command_) return 255;
    const uint32_t age = now - command_tick_;
    return age < 254 ? static_cast<uint8_t>(age) : 254;
  }

  // Until it is known where neutral is, the outputs are not enabled.
  Calibration calibration_ = {{{0, 0, 0, 0}, {0, 0, 0, 0}}, {{0, 2048, 0}, {0, 2048, 0}}, {1, 1, 1, 1}};
  FrameReader reader_;
  Reading reading_ = {0, {0, 0}, {0, 0}, 0, false, false};
  Axes stick_ = {0, 0}, command_ = {0, 0};
  uint32_t command_tick_ = 0, neutral_since_ = 0;
  uint16_t faults_ = 0, bad_frames_ = 0;
  uint8_t doubt_[axes] = {0, 0}, profile_ = 0, sequence_ = 0;
  State state_ = State::neutral_required;
  bool has_command_ = false, asked_ = false, store_ = false;
};

}  // namespace joystick
}  // namespace lfdcore
