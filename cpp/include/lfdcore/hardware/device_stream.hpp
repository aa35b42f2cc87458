// Bytes to and from a device: a serial port or a TCP connection. Linux.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace lfdcore {

/// One open connection; moved, not copied, and closed with its last owner. One thread reads and writes at a time; any
/// thread may call interrupt().
///
/// DeviceError, from every call, says what is wrong with which device and what to do: it is missing, taken by another
/// program, without permission, gone. The stream is of no use then: open another.
class DeviceStream {
 public:
  /// A serial port, raw, 8 data bits, no parity, 1 stop bit, held alone (TIOCEXCL and a lock). baud: a standard rate of
  /// 1200 to 921600. Throws DeviceError, and std::invalid_argument for another rate.
  static DeviceStream open_serial(const std::string& path, int baud);

  /// A TCP connection, made within `patience` [s]. Throws DeviceError.
  static DeviceStream connect_tcp(const std::string& host, std::uint16_t port, double patience);

  DeviceStream(DeviceStream&& other) noexcept;
  DeviceStream& operator=(DeviceStream&& other) noexcept;
  ~DeviceStream();

  /// Waits for bytes, `patience` [s] at the longest, asleep -> how many were read, 0 when it had to wait for longer or
  /// was interrupted.
  std::size_t read(std::uint8_t* bytes, std::size_t most, double patience);

  /// Writes all of them, or throws DeviceError after `patience` [s].
  void write(const std::uint8_t* bytes, std::size_t count, double patience);

  /// Forgets what came in and was not read.
  void discard_input();

  /// Wakes a read() that waits, or the next one.
  void interrupt();

  /// As messages name it: a path, or host:port.
  const std::string& name() const { return name_; }

 private:
  DeviceStream(int file, int wake, std::string name);
  void close();

  int file_ = -1, wake_ = -1;  // wake_: an eventfd
  std::string name_;
};

}  // namespace lfdcore
