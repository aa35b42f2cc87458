#include "lfdcore/hardware/joystick_session.hpp"

#include <algorithm>
#include <cmath>

#include "lfdcore/error.hpp"

namespace lfdcore {

using namespace joystick;

namespace {

// The chip's clock may be so much slower or faster than the host's: a crystal's is 50 ppm, a resonator's 5000.
constexpr double clock_error = 0.01;

double share_of(std::int16_t value) { return static_cast<double>(value) / full; }

std::int16_t count_of(double share) { return static_cast<std::int16_t>(std::lround(share * full)); }

}  // namespace

std::vector<std::uint8_t> JoystickSession::take(const std::uint8_t* bytes, std::size_t count, double stamp) {
  std::vector<std::uint8_t> answers;
  Decoded outcome;
  Frame frame;
  for (std::size_t i = 0; i < count; ++i) {
    if (!reader_.take(bytes[i], outcome, frame)) continue;
    if (outcome != Decoded::frame) {
      ++statistics_.bad_frames;
      other_version_ = other_version_ || outcome == Decoded::wrong_version;
      continue;
    }
    count_sequence(frame.sequence);
    if (frame.type == FrameType::identity) take_identity(frame);
    if (frame.type != FrameType::report) continue;
    take_report(frame, stamp);
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

void JoystickSession::take_report(const Frame& frame, double stamp) {
  Reader reader(frame.payload);
  JoystickReading said;
  said.tick = reader.u32();
  stick_.forward = reader.i16();
  stick_.left = reader.i16();
  said.forward = share_of(stick_.forward);
  said.left = share_of(stick_.left);
  for (std::uint16_t& count : said.adc) count = reader.u16();
  for (std::int32_t& count : said.edges) count = reader.i32();
  said.lost_edges = reader.u16();
  said.given_forward = share_of(reader.i16());
  said.given_left = share_of(reader.i16());
  said.chip = static_cast<State>(std::min<std::uint8_t>(reader.u8(), states - 1));
  said.faults = reader.u16();
  const std::uint8_t inputs = reader.u8();
  said.manual = inputs & 1;
  said.emergency = inputs & 2;
  said.profile = reader.u8();
  said.stamp = stamp_of(said.tick, stamp);
  if (!newest_) {
    ++statistics_.connections;
    not_neutral_ = said.tick;
    happen(Event::link_made);
  }
  if (newest_ && said.profile != newest_->profile) {
    not_neutral_ = said.tick;
    happen(Event::settings_changed);
  }
  if (!is_neutral(stick_)) not_neutral_ = said.tick;
  newest_ = said;
  came_ = stamp;
  ++statistics_.reports;
  judge(stamp);
}

// The quickest report tells how the clocks differ; what comes later than that was under way for longer. A clock that
// drifts away is followed; one that began anew is another one.
double JoystickSession::stamp_of(std::uint32_t tick, double stamp) {
  const double by_chip = tick * 1e-3, offset = stamp - by_chip;
  const bool anew = !newest_ || tick - newest_->tick > 1000;
  if (anew) return offset_ = offset, stamp;
  offset_ = std::min(offset_ + clock_error * (tick - newest_->tick) * 1e-3, offset);
  return by_chip + offset_;
}

void JoystickSession::take_identity(const Frame& frame) {
  identity_ = JoystickIdentity{frame.payload[0], frame.payload[1] != 0, read_calibration(frame.payload + 4)};
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
  require(
      is_sound(calibration),
      "the calibration is not sound: each axis needs its centre between both ends, 50 counts or more from each, ends "
      "from 16 to 1007 and a dead zone of less than half of the way; each output neutral between both ends, 100 "
      "codes or more from each, up to 4095; each profile 1 to 100 %");
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
