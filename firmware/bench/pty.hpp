// A pseudo-terminal as the PC's serial port of the chip.
#pragma once

#include <deque>
#include <string>

namespace bench {

class Pty {
 public:
  /// Throws std::runtime_error where the system gives none.
  Pty();
  ~Pty();
  Pty(const Pty&) = delete;
  Pty& operator=(const Pty&) = delete;

  int fd() const { return fd_; }
  const std::string& path() const { return path_; }

  /// Bytes for the reader, kept while it does not read; beyond 64 KiB the oldest are lost.
  void write(unsigned char byte);
  /// Hands on what the reader takes.
  void flush();
  bool pending() const { return !pending_.empty(); }
  unsigned lost() const { return lost_; }
  /// At most `most` bytes that a writer has written.
  std::string read(std::size_t most);

 private:
  int fd_ = -1, kept_open_ = -1;  // the second: so that neither bytes nor settings go when a user closes it
  std::string path_;
  std::deque<unsigned char> pending_;
  unsigned lost_ = 0;
};

}  // namespace bench
