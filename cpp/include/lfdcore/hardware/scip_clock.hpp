// The clock of a SCIP device by the host's clock.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

namespace lfdcore {

/// Where a device's clock, which counts ms modulo 2^24 (4.66 h), stands by the host's clock [s].
///
/// The offset comes from exchanges: the host asks for the time and knows when it asked and was answered. A device
/// cannot be asked while it measures; from then on the offset follows the scans that come through fastest, by 0.3 ms a
/// second at the most, since a crystal drifts by no more.
class ScipClock {
 public:
  static constexpr double most_drift = 3e-4;  ///< [s/s]
  static constexpr double window = 5.0;       ///< [s] in which one scan is taken to come through fast

  /// The device's clock said `ticks` in the answer to a question asked at `asked` and answered at `answered` [s]. Of
  /// several, the one that took the shortest counts.
  void exchange(std::uint32_t ticks, double asked, double answered);

  /// When it was `ticks`, by the host's clock [s]; never after `received` [s], when that was said. std::nullopt where
  /// the device's clock was set back or is off by more than a second: it began anew, and exchanges are needed.
  std::optional<double> host_time(std::uint32_t ticks, double received);

  /// [ms] from the scan before to the last one by the device's clock, 0 for the first.
  std::int64_t interval() const { return interval_; }

 private:
  void follow(double delay, double received);

  std::uint32_t last_ = 0;
  std::int64_t elapsed_ = 0, interval_ = 0;  // [ms] since the exchange
  bool began_ = false;
  double shortest_ = std::numeric_limits<double>::infinity(), offset_ = 0;
  double window_begin_ = 0, least_ = std::numeric_limits<double>::infinity();
  std::optional<double> usual_;  // [s] the delay of what comes through fastest
};

}  // namespace lfdcore
