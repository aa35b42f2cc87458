// A LIDAR that speaks SCIP 2.0 (Hokuyo UTM-30LX, URG-04LX and their kin), on a serial port or in the network.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "lfdcore/grid/laser_scan.hpp"

namespace lfdcore {

struct ScipConfig {
  int baud = 115200;         ///< of a serial port; USB devices know none
  bool upside_down = false;  ///< mounted hanging: its scans are mirrored
};

/// A scan, and when the scanner's mirror began its turn, by the host's steady clock [s].
struct TimedScan {
  LaserScan scan;
  double stamp = 0;
  std::uint64_t sequence = 0;  ///< 1 for the first scan that was received
};

struct ScipStatistics {
  std::uint64_t scans = 0;       ///< received whole
  std::uint64_t damaged = 0;     ///< replies with a wrong sum or a wrong length, and what was no reply
  std::uint64_t lost = 0;        ///< scans that the device's clock says are missing between those received
  std::uint64_t reconnects = 0;  ///< times that it measured anew after it was lost
};

/// Measures from its construction to close(), in a thread of its own.
///
/// A device that is lost later (unplugged, reset, silent for more than a second) is no error but a state: fault() says
/// what is wrong, newest() grows old, and the thread tries until it measures again.
class ScipLidar {
 public:
  static constexpr double silence = 1.0;     ///< [s] without a scan after which a device is lost
  static constexpr double first_scan = 3.0;  ///< [s] the same before its first
  static constexpr double retry = 0.2;       ///< [s] between attempts to get it back
  static constexpr int port = 10940;         ///< of devices in the network that name none

  /// address: the path of a serial port (/dev/...), or host or host:port. A serial port is tried at config.baud, then
  /// at 115200, 19200, 57600 and 500000. Returns when it measures. Throws DeviceError if it does not: absent, taken, no
  /// SCIP device, broken; std::invalid_argument for an address or a rate that cannot be.
  explicit ScipLidar(const std::string& address, const ScipConfig& config = {});
  ~ScipLidar();

  /// Switches the laser off and ends the thread, within about a second. The last scan stays.
  void close();

  /// The newest scan, at once; std::nullopt before the first. Compare its stamp with now.
  std::optional<TimedScan> newest() const;

  /// Waits for a scan with a higher sequence number, `patience` [s] at the longest.
  std::optional<TimedScan> wait_newer(std::uint64_t sequence, double patience) const;

  ScipStatistics statistics() const;

  /// What is wrong and what to do; empty while it measures.
  std::string fault() const;

  /// As the device calls itself.
  std::string model() const;

  /// [s]
  double scan_period() const;

 private:
  class Worker;
  std::unique_ptr<Worker> worker_;
};

}  // namespace lfdcore
