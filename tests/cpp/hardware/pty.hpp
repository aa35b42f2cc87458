// A pseudo-terminal: a serial port whose device is the test.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <string>
#include <utility>

namespace lfdcore {

class Pty {
 public:
  Pty() : device_(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    char name[64];
    if (device_ < 0 || ::grantpt(device_) || ::unlockpt(device_) || ::ptsname_r(device_, name, sizeof name))
      ADD_FAILURE() << "no pty";
    path_ = name;
  }
  Pty(const Pty&) = delete;
  Pty& operator=(const Pty&) = delete;
  ~Pty() { unplug(); }

  const std::string& path() const { return path_; }
  int device() const { return device_; }

  void unplug() {
    if (device_ >= 0) ::close(std::exchange(device_, -1));
  }

  void say(const std::string& bytes) const {
    ASSERT_EQ(::write(device_, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }

  // The next `count` bytes that came; fewer only after 10 s.
  std::string hear(std::size_t count) const {
    std::string heard;
    for (pollfd wait{device_, POLLIN, 0}; heard.size() < count && ::poll(&wait, 1, 10'000) > 0;) {
      char byte = 0;
      if (::read(device_, &byte, 1) == 1) heard += byte;
    }
    return heard;
  }

  termios settings() const {
    termios now{};
    ::tcgetattr(device_, &now);
    return now;
  }

 private:
  int device_;
  std::string path_;
};

}  // namespace lfdcore
