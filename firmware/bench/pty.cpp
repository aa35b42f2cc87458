#include "pty.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace bench {

namespace {

constexpr std::size_t most_pending = 65536;

void make_raw(int fd) {
  termios settings = {};
  tcgetattr(fd, &settings);
  cfmakeraw(&settings);
  cfsetspeed(&settings, B115200);
  tcsetattr(fd, TCSANOW, &settings);
}

}  // namespace

Pty::Pty() {
  fd_ = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd_ < 0 || grantpt(fd_) != 0 || unlockpt(fd_) != 0)
    throw std::runtime_error(std::string("no pseudo-terminal can be opened: ") + std::strerror(errno));
  path_ = ptsname(fd_);
  kept_open_ = open(path_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (kept_open_ < 0) throw std::runtime_error(path_ + " cannot be opened: " + std::strerror(errno));
  make_raw(kept_open_);
}

Pty::~Pty() {
  close(kept_open_);
  close(fd_);
}

void Pty::write(unsigned char byte) {
  if (pending_.size() == most_pending) {
    pending_.pop_front();
    ++lost_;
  }
  pending_.push_back(byte);
}

void Pty::flush() {
  std::array<unsigned char, 512> chunk;
  while (!pending_.empty()) {
    const std::size_t size = std::min(chunk.size(), pending_.size());
    std::copy_n(pending_.begin(), size, chunk.begin());
    const ssize_t taken = ::write(fd_, chunk.data(), size);
    if (taken <= 0) return;
    pending_.erase(pending_.begin(), pending_.begin() + taken);
  }
}

std::string Pty::read(std::size_t most) {
  std::string bytes(most, '\0');
  const ssize_t size = ::read(fd_, bytes.data(), most);
  bytes.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
  return bytes;
}

}  // namespace bench
