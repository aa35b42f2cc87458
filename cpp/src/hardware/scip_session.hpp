// One conversation with a SCIP device, from its greeting to its scans.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "lfdcore/hardware/device_stream.hpp"
#include "lfdcore/hardware/scip_clock.hpp"
#include "lfdcore/hardware/scip_codec.hpp"

namespace lfdcore {

/// The steady clock that stamps are of [s].
double host_now();

/// Asks and listens. DeviceError, from every call, where the stream is lost, the device does not do what it should, or
/// `stopping` became true (the stream is to be interrupted then).
class ScipSession {
 public:
  ScipSession(DeviceStream stream, const std::atomic<bool>& stopping);

  /// Whether a SCIP device answers, brought to SCIP 2.0 and to silence.
  bool greet();

  /// What came instead of an answer to greet(), in words.
  std::string heard() const;

  /// From a greeted device to one that measures: reads its parameters and its clock, and switches on its laser.
  void start();

  /// Waits `patience` [s] at the longest for the next reply to the measure command.
  std::optional<std::string_view> next_measurement(double patience);

  /// Switches its laser off, if it still listens.
  void quit() noexcept;

  const ScipParameters& parameters() const { return parameters_; }
  const std::string& name() const { return stream_.name(); }
  ScipClock& clock() { return clock_; }
  void interrupt() { stream_.interrupt(); }
  /// Replies that were none that this session asked for.
  std::uint64_t strange() const { return strange_; }

  /// "status 10: its laser is off", for a reply to `command`.
  static std::string said(std::string_view command, std::string_view status);

 private:
  using Use = std::function<bool(const ScipReply&)>;

  void send(const std::string& command);
  std::optional<std::string_view> next_reply(double deadline);
  bool ask(const std::string& command, double patience, const Use& use);
  void demand(const std::string& command, const Use& use);
  void demand(const std::string& command, std::string_view also);
  void require_scip_2();
  void read_clock();
  void switch_on();
  std::string state();

  DeviceStream stream_;
  const std::atomic<bool>& stopping_;
  ScipReplies replies_;
  ScipParameters parameters_;
  ScipClock clock_;
  std::string measure_;
  std::uint64_t strange_ = 0, bytes_ = 0;
};

}  // namespace lfdcore
