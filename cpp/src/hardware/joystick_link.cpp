#include "lfdcore/hardware/joystick_link.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

using Seconds = std::chrono::duration<double>;

constexpr double watching = 0.05;      // [s] between looks at the time
constexpr double looking_again = 0.1;  // [s] between looks for a port that is gone
constexpr double writing = 0.1;        // [s] for which a write may block
constexpr double looking_round = 0.1;  // [s] between what is done while a report is waited for
constexpr double farewell = 0.03;      // [s] for the last answer
constexpr double answering = 1;        // [s] for who the chip is

}  // namespace

double JoystickLink::now() { return Seconds(std::chrono::steady_clock::now().time_since_epoch()).count(); }

JoystickLink::JoystickLink(std::string port, double patience, const std::function<void()>& meanwhile)
    : port_((require_between("patience", patience, 0.01, 60, "s"), std::move(port))),
      stream_(DeviceStream::open_serial(port_, baud)),
      owner_(::getpid()),
      thread_([this] { run(); }) {
  try {
    if (wait_for_report(patience, meanwhile)) return;
  } catch (...) {
    close();
    throw;
  }
  std::unique_lock lock(mutex_);
  const std::string why = why_no_report();
  lock.unlock();
  close();
  throw DeviceError(why);
}

bool JoystickLink::wait_for_report(double patience, const std::function<void()>& meanwhile) {
  const auto has_report = [this] { return session_.newest().has_value(); };
  for (const double end = now() + patience; now() < end;) {
    std::unique_lock lock(mutex_);
    if (changed_.wait_for(lock, Seconds(std::min(looking_round, end - now())), has_report)) return true;
    lock.unlock();
    if (meanwhile) meanwhile();
  }
  return false;
}

JoystickLink::~JoystickLink() { close(); }

void JoystickLink::close() {
  const std::lock_guard only_one(closing_);
  if (!thread_.joinable()) return;
  if (owner_ != ::getpid()) return thread_.detach();  // a forked process has the link, but not its thread
  say_farewell();
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    if (stream_) stream_->interrupt();
  }
  changed_.notify_all();
  thread_.join();
  lose(port_ + " was closed");
}

// The chip is neutral at once, and not when it has waited for the next answer.
void JoystickLink::say_farewell() {
  std::unique_lock lock(mutex_);
  session_.command(0, 0, now());
  const long answers = session_.statistics().answers;
  changed_.wait_for(lock, Seconds(farewell),
                    [&] { return !session_.newest() || session_.statistics().answers > answers; });
}

std::string JoystickLink::why_no_report() const {
  if (session_.met_other_version())
    return port_ + " speaks another version of the protocol: flash the firmware of this version of lfdcore";
  if (session_.hears_nonsense())
    return port_ + " sends something else than the firmware of this lfdcore: is it the right port, at " +
           std::to_string(baud) + " baud? If so, flash it (make -C firmware flash)";
  return port_ + " is silent: is the joystick's firmware on it (make -C firmware flash)?";
}

std::optional<JoystickReading> JoystickLink::read() const {
  const std::lock_guard lock(mutex_);
  return session_.newest();
}

std::vector<JoystickReading> JoystickLink::take_readings() {
  const std::lock_guard lock(mutex_);
  return session_.take_readings();
}

void JoystickLink::command(double forward, double left, double duration) {
  const std::lock_guard lock(mutex_);
  session_.command(forward, left, now(), duration);
}

joystick::State JoystickLink::state() const {
  const std::lock_guard lock(mutex_);
  return session_.state();
}

LinkStatistics JoystickLink::statistics() const {
  const std::lock_guard lock(mutex_);
  return session_.statistics();
}

std::string JoystickLink::fault() const {
  const std::lock_guard lock(mutex_);
  return session_.newest() ? "" : fault_;
}

JoystickIdentity JoystickLink::identity() {
  std::unique_lock lock(mutex_);
  require_open();
  session_.forget_identity();
  send(session_.query());
  return wait_for_identity(lock);
}

JoystickIdentity JoystickLink::wait_for_identity(std::unique_lock<std::mutex>& lock) {
  if (!changed_.wait_for(lock, Seconds(answering), [this] { return session_.identity().has_value(); }))
    throw DeviceError(port_ + " does not say who it is: " +
                      (session_.newest() ? "flash the firmware of this lfdcore (make -C firmware flash)" : fault_));
  return *session_.identity();
}

void JoystickLink::require_open() const {
  if (stopping_) throw DeviceError(fault_);
}

void JoystickLink::calibrate(const joystick::Calibration& calibration) {
  std::unique_lock lock(mutex_);
  require_open();
  send(session_.set_calibration(calibration));
  std::array<std::uint8_t, joystick::calibration_bytes> wanted{}, has{};
  joystick::write_calibration(calibration, wanted.data());
  joystick::write_calibration(wait_for_identity(lock).calibration, has.data());
  if (wanted != has) throw DeviceError(port_ + " did not take the calibration: let the stick go, and try again");
}

void JoystickLink::select_profile(std::uint8_t profile) {
  const std::lock_guard lock(mutex_);
  send(session_.select_profile(profile));
}

void JoystickLink::send(const std::vector<std::uint8_t>& bytes) {
  to_send_.insert(to_send_.end(), bytes.begin(), bytes.end());
  if (stream_) stream_->interrupt();
}

void JoystickLink::run() {
  while (true) {
    try {
      if (!stream_) {
        DeviceStream opened = DeviceStream::open_serial(port_, baud);
        const std::lock_guard lock(mutex_);
        stream_ = std::move(opened);
      }
      serve();
      return;
    } catch (const DeviceError& error) {
      lose(error.what());
    }
    if (!wait_to_look_again()) return;
  }
}

// Until the link is to stop; DeviceError when the port is gone.
void JoystickLink::serve() {
  std::array<std::uint8_t, 256> bytes;
  while (true) {
    const std::size_t count = stream_->read(bytes.data(), bytes.size(), watching);
    std::vector<std::uint8_t> out;
    {
      const std::lock_guard lock(mutex_);
      if (stopping_) return;
      const double stamp = now();
      out = session_.take(bytes.data(), count, stamp);
      session_.watch(stamp);
      if (!session_.newest()) fault_ = why_no_report();
      out.insert(out.end(), to_send_.begin(), to_send_.end());
      to_send_.clear();
    }
    changed_.notify_all();
    if (!out.empty()) stream_->write(out.data(), out.size(), writing);
  }
}

void JoystickLink::lose(const std::string& why) {
  const std::lock_guard lock(mutex_);
  stream_.reset();
  session_.lose_link();
  to_send_.clear();
  fault_ = why;
}

// False when the link is to stop.
bool JoystickLink::wait_to_look_again() {
  std::unique_lock lock(mutex_);
  return !changed_.wait_for(lock, Seconds(looking_again), [this] { return stopping_; });
}

}  // namespace lfdcore
