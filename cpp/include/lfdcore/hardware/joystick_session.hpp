// The PC's side of the joystick's link (docs/joystick-link.md), without a port and without a clock: bytes in, bytes
// out.
#pragma once

#include <array>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "lfdcore/hardware/calibration.hpp"
#include "lfdcore/hardware/frame_codec.hpp"
#include "lfdcore/hardware/link_state.hpp"

namespace lfdcore {

/// What the newest report says. Stick and output: -1 to 1, ahead and to the left.
struct JoystickReading {
  double stamp = 0;        ///< [s] of the host's clock, when the stick was read: never after the report came
  std::uint32_t tick = 0;  ///< [ms] of the chip's clock, the same
  long run = 0;            ///< how often the chip began anew, as far as can be told: edges of two runs do not compare
  double forward = 0, left = 0;
  std::array<std::uint16_t, 2> adc{};        ///< [counts] of both axes
  std::array<std::int32_t, 2> edges{};       ///< of the left and the right wheel's encoder; wraps around
  std::uint16_t lost_edges = 0;              ///< wraps around
  double given_forward = 0, given_left = 0;  ///< what the chair's controller is given
  joystick::State chip = joystick::State::disconnected;
  std::uint16_t faults = 0;  ///< bits of joystick::Fault
  bool manual = false, emergency = false;
  std::uint8_t profile = 0;
};

/// Counted since the beginning.
struct LinkStatistics {
  long reports = 0;
  long lost_reports = 0;  ///< gaps in what the chip counts
  long bad_frames = 0;    ///< that came in and were none
  long answers = 0;
  long connections = 0;  ///< begun with a report after there was none, or of a chip that began anew
};

namespace joystick {
/// What is_sound asks for, as an error says it.
constexpr const char* sound_calibration =
    "the calibration is not sound: each axis needs its centre between both ends, 50 counts or more from each, ends "
    "from 51 to 972 (5 to 95 % of the supply) and a dead zone of at most half of the way; each output neutral between "
    "both ends, 100 codes or "
    "more "
    "from each, up to 4095; each profile 1 to 100 %";
}  // namespace joystick

/// Who the chip is.
struct JoystickIdentity {
  std::uint8_t firmware = 0;
  bool calibrated = false;
  joystick::Calibration calibration{};
};

/// Answers each report with a command, made of the newest stick and the newest that an assistant said. Stamps are of
/// one clock of the host, [s].
class JoystickSession {
 public:
  static constexpr double link_lost_after = 0.1;  ///< [s] without a report
  static constexpr double expiry = 0.25;          ///< [s] after which an assistant's command is none

  /// Takes bytes that came at `stamp` -> what is to be sent at once.
  std::vector<std::uint8_t> take(const std::uint8_t* bytes, std::size_t count, double stamp);

  /// Looks at the time. To be called at least every 50 ms.
  void watch(double stamp);

  /// The port is gone: so is the link.
  void lose_link();

  /// What the chair is to do, -1 to 1 of full output, from `stamp` on for `duration` [s], `expiry` at the longest. What
  /// is not finite or out of range is a fault, until something sound is said and the stick was at neutral.
  void command(double forward, double left, double stamp, double duration = expiry);

  void forget_identity() { identity_.reset(); }
  /// Bytes that ask who the chip is.
  std::vector<std::uint8_t> query();
  /// Bytes that set what is stored. Throws std::invalid_argument for a calibration that is not sound.
  std::vector<std::uint8_t> set_calibration(const joystick::Calibration& calibration);
  /// Bytes that select a profile. Throws std::invalid_argument for one that there is not.
  std::vector<std::uint8_t> select_profile(std::uint8_t profile);

  joystick::State state() const { return state_; }
  /// All readings since this was called last, the oldest first: of the last 2 s at most.
  std::vector<JoystickReading> take_readings();
  /// Nothing while disconnected.
  const std::optional<JoystickReading>& newest() const { return newest_; }
  const std::optional<JoystickIdentity>& identity() const { return identity_; }
  const LinkStatistics& statistics() const { return statistics_; }
  /// Whether more came since the last report than a frame is long: so they were none.
  bool hears_nonsense() const { return unheard_ > joystick::most_wire; }
  /// Of the protocol, if a frame of another version came in: then the firmware is another one's.
  bool met_other_version() const { return other_version_; }

 private:
  struct Wanted {
    joystick::Axes value;
    double until;
  };

  void happen(joystick::Event event) { state_ = joystick::next(state_, event); }
  std::vector<std::uint8_t> frame(joystick::FrameType type, const std::uint8_t* payload);
  bool take_report(const joystick::Frame& frame, double stamp);
  void count_bad_frame();
  void connect(const JoystickReading& said);
  void take_identity(const joystick::Frame& frame);
  void judge(double stamp);
  std::vector<std::uint8_t> answer();
  double stamp_of(std::uint32_t tick, double stamp);
  void count_sequence(std::uint8_t sequence);

  joystick::FrameReader reader_;
  joystick::State state_ = joystick::State::disconnected;
  std::optional<JoystickReading> newest_;
  std::optional<JoystickReading> last_;  // also while disconnected
  std::deque<JoystickReading> readings_;
  std::optional<JoystickIdentity> identity_;
  std::optional<Wanted> wanted_;
  LinkStatistics statistics_;
  std::optional<std::uint8_t> last_sequence_;
  double quickest_ = 0;  // when the newest report would have come, had it been no slower than the quickest
  double came_ = 0;      // when it came
  joystick::Axes stick_{0, 0};
  std::uint32_t not_neutral_ = 0;  // tick of the last report with the stick out
  std::uint8_t sequence_ = 0;
  bool bad_command_ = false, other_version_ = false;
  std::size_t unheard_ = 0;  // bytes since the last report
};

}  // namespace lfdcore
