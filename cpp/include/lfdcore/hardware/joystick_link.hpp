// The link to the Arduino at the joystick, through a serial port (docs/joystick-link.md).
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "lfdcore/hardware/device_stream.hpp"
#include "lfdcore/hardware/joystick_session.hpp"

namespace lfdcore {

/// Answers each report by itself, in a thread of its own, which sleeps until bytes come. A cable that is pulled out is
/// a state, not an error: the thread looks for the port until it is there again. No call waits for the chip but those
/// that say so.
class JoystickLink {
 public:
  static constexpr int baud = 115200;

  /// Opens the port and waits for the first report, `patience` [s] at the longest, 60 at most. Throws DeviceError for a
  /// port that cannot be opened, and for one at which nothing, or something else, talks. `meanwhile` is called ten
  /// times a second; what it throws ends the waiting.
  explicit JoystickLink(std::string port, double patience = 3, const std::function<void()>& meanwhile = {});
  ~JoystickLink();
  JoystickLink(const JoystickLink&) = delete;
  JoystickLink& operator=(const JoystickLink&) = delete;

  /// Commands 0, waits until a report has been answered with it (30 ms at the longest), ends the thread and lets the
  /// port go; then the state is `disconnected`.
  void close();

  /// What the newest report says; nothing while there is none.
  std::optional<JoystickReading> read() const;

  /// All readings since this was called last, the oldest first: of the last 2 s at most.
  std::vector<JoystickReading> take_readings();

  /// What the chair is to do from now on, as JoystickSession::command.
  void command(double forward, double left, double duration = JoystickSession::expiry);

  /// As the table has it.
  joystick::State state() const;
  LinkStatistics statistics() const;
  /// Why there is no link; empty while there is one.
  std::string fault() const;

  /// Asks who the chip is, and waits. Throws DeviceError without an answer within a second.
  JoystickIdentity identity();
  /// Stores a calibration in the chip, and waits. Throws std::invalid_argument for one that is not sound, DeviceError
  /// where the chip did not take it: it drives, or does not answer.
  void calibrate(const joystick::Calibration& calibration);
  /// Selects a profile; the stick is needed at neutral then. Throws std::invalid_argument for one that there is not.
  void select_profile(std::uint8_t profile);

  const std::string& port() const { return port_; }
  /// Of the host's clock, as stamps have it [s]: std::chrono::steady_clock.
  static double now();

 private:
  void run();
  void serve();
  void lose(const std::string& why);
  bool wait_to_look_again();
  void send(const std::vector<std::uint8_t>& bytes);
  JoystickIdentity wait_for_identity(std::unique_lock<std::mutex>& lock);
  bool wait_for_report(double patience, const std::function<void()>& meanwhile);
  void say_farewell();
  void require_open() const;
  std::string why_no_report() const;

  std::string port_;
  mutable std::mutex mutex_;  // of all below
  std::condition_variable changed_;
  JoystickSession session_;
  std::vector<std::uint8_t> to_send_;
  std::string fault_ = "not yet connected";
  bool stopping_ = false;
  std::mutex closing_;
  std::optional<DeviceStream> stream_;  // of the thread alone, but for interrupt()
  int owner_;                           // the process whose thread it is
  std::thread thread_;
};

}  // namespace lfdcore
