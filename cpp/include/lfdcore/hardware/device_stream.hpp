// Bytes to and from a device: a serial port or a TCP connection. Linux.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace lfdcore {

/// One open connection; moved, not copied, and closed with its last owner. One thread reads and one writes at a time;
/// any thread may call interrupt().
///
/// DeviceError, from every call but discard_input() and interrupt(), says what is wrong with which device and what to
/// do: it is missing, taken by another program, without permission, gone. The stream is of no use then: open another.
class DeviceStream {
 public:
  /// A serial port, raw, 8 data bits, no parity, 1 stop bit, no flow control, held alone (TIOCEXCL and a lock); what
  /// came in before is forgotten. baud: a standard rate of 1200 to 921600. Throws DeviceError, and
  /// std::invalid_argument for another rate.
  static DeviceStream open_serial(const std::string& path, int baud);

  /// A TCP connection, made within `patience` [s], the look-up of the host's name included. Throws DeviceError.
  static DeviceStream connect_tcp(const std::string& host, std::uint16_t port, double patience);

  DeviceStream(DeviceStream&& other) noexcept;
  DeviceStream& operator=(DeviceStream&& other) noexcept;
  ~DeviceStream();

  /// Waits for bytes, `patience` [s] at the longest (infinity: for ever), asleep -> how many were read, 0 when it had
  /// to wait for longer or was interrupted.
  std::size_t read(std::uint8_t* bytes, std::size_t most, double patience);

  /// Writes all of them, or throws DeviceError after `patience` [s]. An interrupt() does not wake it.
  void write(const std::uint8_t* bytes, std::size_t count, double patience);

  /// Forgets what came in and was not read.
  void discard_input();

  /// Wakes a read() that waits, or the next one.
  void interrupt();

  /// As messages name it: a path, or host:port.
  const std::string& name() const { return name_; }

 private:
  DeviceStream(int file, std::string name);
  void close();
  std::size_t read_some(std::uint8_t* bytes, std::size_t most, bool hung_up);
  std::size_t write_some(const std::uint8_t* bytes, std::size_t count, bool hung_up);
  bool is_interrupted();
  [[noreturn]] void lose(int error) const;

  int file_ = -1, wake_ = -1;  // wake_: an eventfd
  int owner_ = 0;              // the process that opened it
  bool is_socket_ = false;
  std::string name_;
};

}  // namespace lfdcore
