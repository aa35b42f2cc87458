#include "lfdcore/hardware/joystick_session.hpp"

#include <algorithm>
#include <cmath>

#include "lfdcore/error.hpp"

namespace lfdcore {

using namespace joystick;

namespace {

// The chip's clock may be so much slower or faster than the host's: a crystal's is 50 ppm, a resonator's 5000.
constexpr double clock_error = 0.01;
// [s] that two reports may be under way for differently
constexpr double clock_jitter = 0.1;
constexpr std::size_t most_readings = 2000 / report_ms;

double share_of(std::int16_t value) { return static_cast<double>(value) / full; }

std::int16_t count_of(double share) { return static_cast<std::int16_t>(std::lround(share * full)); }

// Whether the chip may have counted on between two readings: its clock went on as the host's did.
bool goes_on(const JoystickReading& before, const JoystickReading& now) {
  const double passed = now.stamp - before.stamp, by_chip = (now.tick - before.tick) * 1e-3;
  return std::abs(by_chip - passed) <= clock_error * passed + clock_jitter;
}

// -> whether it can be true: another firmware may have other numbers.
bool read_report(const std::uint8_t* payload, Axes& stick, JoystickReading& said) {
  Reader reader(payload);
  said.tick = reader.u32();
  const std::int16_t forward = reader.i16(), left = reader.i16();
  for (std::uint16_t& count : said.adc) count = reader.u16();
  for (std::int32_t& count : said.edges) count = reader.i32();
  said.lost_edges = reader.u16();
  const std::int16_t given_forward = reader.i16(), given_left = reader.i16();
  const std::uint8_t state = reader.u8();
  said.faults = reader.u16();
  const std::uint8_t inputs = reader.u8();
  said.profile = reader.u8();
  if (!is_in_range({forward, left}) || !is_in_range({given_forward, given_left})) return false;
  if (state >= static_cast<std::uint8_t>(State::disconnected) || said.profile >= profiles) return false;
  stick = {forward, left};
  said.forward = share_of(forward);
  said.left = share_of(left);
  said.given_forward = share_of(given_forward);
  said.given_left = share_of(given_left);
  said.chip = static_cast<State>(state);
  said.manual = inputs & 1;
  said.emergency = inputs & 2;
  return true;
}

}  // namespace

std::vector<std::uint8_t> JoystickSession::take(const std::uint8_t* bytes, std::size_t count, double stamp) {
  std::vector<std::uint8_t> answers;
  Decoded outcome;
  Frame frame;
  unheard_ += count;
  for (std::size_t i = 0; i < count; ++i) {
    if (!reader_.take(bytes[i], outcome, frame)) continue;
    if (outcome != Decoded::frame) {
      count_bad_frame();
      other_version_ = other_version_ || outcome == Decoded::wrong_version;
      continue;
    }
    if (frame.type == FrameType::identity) take_identity(frame);
    const bool report = frame.type == FrameType::report && take_report(frame, stamp);
    count_sequence(frame.sequence);
    if (!report) continue;
    const std::vector<std::uint8_t> sent = answer();
    answers.insert(answers.end(), sent.begin(), sent.end());
  }
  return answers;
}

void JoystickSession::watch(double stamp) {
  if (newest_ && stamp - came_ > link_lost_after) lose_link();
  judge(stamp);
}

void JoystickSession::lose_link() {
  newest_.reset();
  last_sequence_.reset();
  happen(Event::link_lost);
}

void JoystickSession::command(double forward, double left, double stamp, double duration) {
  bad_command_ = !(std::abs(forward) <= 1 && std::abs(left) <= 1 && duration > 0 && std::isfinite(stamp));
  wanted_.reset();
  if (!bad_command_) wanted_ = Wanted{{count_of(forward), count_of(left)}, stamp + std::min(duration, expiry)};
  judge(stamp);
}

bool JoystickSession::take_report(const Frame& frame, double stamp) {
  JoystickReading said;
  if (!read_report(frame.payload, stick_, said)) {
    count_bad_frame();
    return false;
  }
  if (newest_ && static_cast<std::int32_t>(said.tick - newest_->tick) < 0) lose_link();  // the chip was reset
  said.stamp = stamp_of(said.tick, stamp);
  said.run = last_ ? last_->run + !goes_on(*last_, said) : 0;
  if (!newest_) connect(said);
  if (newest_ && said.profile != newest_->profile) {
    not_neutral_ = said.tick;
    happen(Event::settings_changed);
  }
  if (!is_neutral(stick_) || said.faults != 0) not_neutral_ = said.tick;
  newest_ = last_ = said;
  came_ = stamp;
  unheard_ = 0;
  readings_.push_back(said);
  if (readings_.size() > most_readings) readings_.pop_front();
  ++statistics_.reports;
  judge(stamp);
  return true;
}

void JoystickSession::connect(const JoystickReading& said) {
  ++statistics_.connections;
  not_neutral_ = said.tick;
  happen(Event::link_made);
}

void JoystickSession::count_bad_frame() { ++statistics_.bad_frames; }

std::vector<JoystickReading> JoystickSession::take_readings() {
  std::vector<JoystickReading> taken(readings_.begin(), readings_.end());
  readings_.clear();
  return taken;
}

// The quickest report tells how the clocks differ; what comes later than that was under way for longer. A clock that
// drifts away is followed; one that began anew is another one. The chip's ticks wrap around after 49 days.
double JoystickSession::stamp_of(std::uint32_t tick, double stamp) {
  const std::uint32_t passed = newest_ ? tick - newest_->tick : 0;
  if (!newest_ || passed > 1000) return quickest_ = stamp;
  quickest_ = std::min(quickest_ + (1 + clock_error) * passed * 1e-3, stamp);
  return quickest_;
}

void JoystickSession::take_identity(const Frame& frame) {
  const JoystickIdentity said{frame.payload[0], frame.payload[1] != 0, read_calibration(frame.payload + 4)};
  if (said.calibrated && !is_sound(said.calibration)) return count_bad_frame();
  identity_ = said;
}

// What the table says of all that is known now.
void JoystickSession::judge(double stamp) {
  if (!newest_) return;
  if (newest_->tick - not_neutral_ >= neutral_ms) happen(Event::stick_neutral);
  if (newest_->chip == State::neutral_required && state_ != State::neutral_required) happen(Event::settings_changed);
  happen(newest_->emergency ? Event::emergency_pressed : Event::emergency_released);
  happen(newest_->faults != 0 || bad_command_ ? Event::fault_found : Event::fault_gone);
  if (wanted_ && stamp > wanted_->until) wanted_.reset();
  happen(wanted_ ? Event::command_fresh : Event::command_old);
}

std::vector<std::uint8_t> JoystickSession::answer() {
  const Axes given = state_ == State::driving && wanted_ ? allowed(wanted_->value, stick_) : Axes{0, 0};
  std::uint8_t payload[8];
  Writer writer(payload);
  writer.u32(newest_->tick);
  writer.i16(given.forward);
  writer.i16(given.left);
  ++statistics_.answers;
  return frame(FrameType::command, payload);
}

std::vector<std::uint8_t> JoystickSession::frame(FrameType type, const std::uint8_t* payload) {
  std::vector<std::uint8_t> wire(most_wire);
  wire.resize(encode_frame(type, sequence_++, payload, wire.data()));
  return wire;
}

std::vector<std::uint8_t> JoystickSession::query() { return frame(FrameType::query, nullptr); }

std::vector<std::uint8_t> JoystickSession::set_calibration(const Calibration& calibration) {
  require(is_sound(calibration), sound_calibration);
  std::uint8_t payload[calibration_bytes];
  write_calibration(calibration, payload);
  identity_.reset();
  return frame(FrameType::set_calibration, payload);
}

std::vector<std::uint8_t> JoystickSession::select_profile(std::uint8_t profile) {
  require_between("profile", profile, 0, profiles - 1, "");
  return frame(FrameType::select_profile, &profile);
}

void JoystickSession::count_sequence(std::uint8_t sequence) {
  if (last_sequence_) statistics_.lost_reports += static_cast<std::uint8_t>(sequence - *last_sequence_ - 1);
  last_sequence_ = sequence;
}

}  // namespace lfdcore
