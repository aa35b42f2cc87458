// A TCP device on this computer.
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <utility>

namespace lfdcore {

class Listener {
 public:
  explicit Listener(int backlog = 8) : file_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = ::htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    if (::bind(file_, reinterpret_cast<sockaddr*>(&address), size) || ::listen(file_, backlog) ||
        ::getsockname(file_, reinterpret_cast<sockaddr*>(&address), &size))
      ADD_FAILURE() << "no listener";
    port_ = ::ntohs(address.sin_port);
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
  ~Listener() { close(); }

  std::uint16_t port() const { return port_; }
  int accept() const { return ::accept4(file_, nullptr, nullptr, SOCK_CLOEXEC); }
  void close() {
    if (file_ >= 0) ::close(std::exchange(file_, -1));
  }

 private:
  int file_;
  std::uint16_t port_ = 0;
};

}  // namespace lfdcore
