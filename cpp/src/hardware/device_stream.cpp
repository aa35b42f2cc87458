#include "lfdcore/hardware/device_stream.hpp"

#include <fcntl.h>
#include <glob.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <future>
#include <limits>
#include <memory>
#include <sstream>
#include <thread>
#include <utility>
#include <vector>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::pair<int, speed_t> rates[] = {{1200, B1200},     {2400, B2400},     {4800, B4800},     {9600, B9600},
                                             {19200, B19200},   {38400, B38400},   {57600, B57600},   {115200, B115200},
                                             {230400, B230400}, {460800, B460800}, {500000, B500000}, {576000, B576000},
                                             {921600, B921600}};

[[noreturn]] void fail(const std::string& device, const std::string& what) { throw DeviceError(device + ": " + what); }

std::string reason(int error) { return std::generic_category().message(error); }

std::string seconds(double time) {
  std::ostringstream text;
  text << time << " s";
  return text.str();
}

// A file that an error on the way closes.
class File {
 public:
  explicit File(int file) : file_(file) {}
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  ~File() {
    if (file_ >= 0) ::close(file_);
  }

  int get() const { return file_; }
  int release() { return std::exchange(file_, -1); }

 private:
  int file_;
};

class Deadline {
 public:
  explicit Deadline(double patience) : never_(patience == std::numeric_limits<double>::infinity()) {
    require(patience >= 0, "the patience for a device must be >= 0 s, not " + std::to_string(patience) + " s");
    // Later than in 30 years does not fit the clock.
    end_ = Clock::now() +
           std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(std::min(patience, 1e9)));
  }

  Clock::duration left() const { return std::max(Clock::duration::zero(), end_ - Clock::now()); }
  bool is_over() const { return !never_ && left() == Clock::duration::zero(); }

  // Waits for what the files ask for -> how many of them have something; 0: it is over, or a signal came.
  int poll(pollfd* files, nfds_t count) const {
    const auto nanoseconds = std::chrono::duration_cast<std::chrono::nanoseconds>(left()).count();
    const timespec time{nanoseconds / 1'000'000'000, nanoseconds % 1'000'000'000};
    return std::max(0, ::ppoll(files, count, never_ ? nullptr : &time, nullptr));
  }

 private:
  Clock::time_point end_;
  bool never_;
};

speed_t speed_of(int baud) {
  for (const auto& [rate, speed] : rates)
    if (rate == baud) return speed;
  std::string known;
  for (const auto& rate : rates) known += (known.empty() ? "" : ", ") + std::to_string(rate.first);
  throw std::invalid_argument("baud is " + std::to_string(baud) + ", must be one of " + known);
}

std::string ports_here() {
  glob_t found{};
  ::glob("/dev/ttyACM*", 0, nullptr, &found);
  ::glob("/dev/ttyUSB*", GLOB_APPEND, nullptr, &found);
  std::string ports;
  for (std::size_t i = 0; i < found.gl_pathc; ++i) ports += std::string(i ? ", " : "") + found.gl_pathv[i];
  ::globfree(&found);
  return ports.empty() ? "none" : ports;
}

[[noreturn]] void fail_to_open(const std::string& path, int error) {
  switch (error) {
    case ENOENT:
    case ENOTDIR:
      fail(path, "there is no such device; plug it in, or name another (serial ports here: " + ports_here() + ")");
    case ENXIO:
    case ENODEV:
    case EIO:
      fail(path, "no device answers there (" + reason(error) + "); plug it in again");
    case EACCES:
    case EPERM:
      fail(path,
           "no permission; 'sudo usermod -aG dialout $USER' puts you into the group that has it, then log in "
           "again");
    case EBUSY:
    case EWOULDBLOCK:
      fail(path, "taken by another program; close that one ('fuser " + path + "' names it)");
    case ENOTTY:
    case EISDIR:
      fail(path, "not a serial port; name one (serial ports here: " + ports_here() + ")");
    default:
      fail(path, "cannot be opened: " + reason(error));
  }
}

// -> 0, or why it cannot be.
int make_raw(int file, speed_t speed) {
  termios settings{};
  if (::tcgetattr(file, &settings) != 0) return errno;
  ::cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;  // a device without modem lines is there, too
  settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS);
  settings.c_iflag &= ~static_cast<tcflag_t>(IXOFF | IXANY | INPCK);
  settings.c_cc[VMIN] = 1;  // so that a read of 0 bytes means that the device is gone
  settings.c_cc[VTIME] = 0;
  ::cfsetispeed(&settings, speed);
  ::cfsetospeed(&settings, speed);
  return ::tcsetattr(file, TCSANOW, &settings) == 0 ? 0 : errno;
}

// tcsetattr succeeds if it could set anything at all.
bool runs_at(int file, speed_t speed) {
  termios settings{};
  return ::tcgetattr(file, &settings) == 0 && ::cfgetospeed(&settings) == speed;
}

using Addresses = std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)>;

std::pair<int, Addresses> look_up_now(const std::string& host, std::uint16_t port) {
  addrinfo wanted{}, *found = nullptr;
  wanted.ai_socktype = SOCK_STREAM;
  const int error = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &wanted, &found);
  return {error, Addresses(error == 0 ? found : nullptr, &::freeaddrinfo)};
}

// A name server may take minutes, and getaddrinfo knows no limit: a thread of its own waits for it then.
Addresses look_up(const std::string& host, std::uint16_t port, const Deadline& deadline, const std::string& name) {
  std::packaged_task<std::pair<int, Addresses>()> task([host, port] { return look_up_now(host, port); });
  auto answer = task.get_future();
  std::thread(std::move(task)).detach();
  if (answer.wait_for(deadline.left()) != std::future_status::ready)
    fail(name, "looking up the host '" + host + "' takes too long; check the network, or give its IP address");
  auto [error, addresses] = answer.get();
  if (error != 0)
    fail(name, "unknown host '" + host + "' (" + ::gai_strerror(error) + "); check its name, or give its IP address");
  return std::move(addresses);
}

// -> 0, or why it did not come about.
int connect_within(int file, const addrinfo& address, const Deadline& deadline) {
  if (::connect(file, address.ai_addr, address.ai_addrlen) == 0) return 0;
  if (errno != EINPROGRESS && errno != EINTR) return errno;
  pollfd wait{file, POLLOUT, 0};
  while (deadline.poll(&wait, 1) == 0)
    if (deadline.is_over()) return ETIMEDOUT;
  int error = 0;
  socklen_t size = sizeof error;
  return ::getsockopt(file, SOL_SOCKET, SO_ERROR, &error, &size) == 0 ? error : errno;
}

[[noreturn]] void fail_to_connect(const std::string& name, int error, double patience) {
  switch (error) {
    case ECONNREFUSED:
      fail(name, "refuses the connection; check the port, and that the device has started");
    case ETIMEDOUT:
      fail(name, "no answer within " + seconds(patience) + "; check its power, its cable and its address");
    case EHOSTUNREACH:
    case ENETUNREACH:
      fail(name, "cannot be reached (" + reason(error) + "); check the cable, and this computer's network settings");
    default:
      fail(name, "cannot be connected: " + reason(error));
  }
}

// What travels at once: commands to a device are a few bytes each.
void send_at_once(int file) {
  const int yes = 1;
  ::setsockopt(file, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
}

bool try_again(int error) { return error == EINTR || error == EAGAIN || error == EWOULDBLOCK; }

}  // namespace

DeviceStream DeviceStream::open_serial(const std::string& path, int baud) {
  const speed_t speed = speed_of(baud);
  File file(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (file.get() < 0) fail_to_open(path, errno);
  if (!::isatty(file.get())) fail_to_open(path, errno == EIO ? EIO : ENOTTY);
  if (::flock(file.get(), LOCK_EX | LOCK_NB) != 0) fail_to_open(path, errno);
  if (const int error = make_raw(file.get(), speed)) fail_to_open(path, error);
  if (!runs_at(file.get(), speed)) fail(path, "cannot run at " + std::to_string(baud) + " baud; choose another rate");
  ::ioctl(file.get(), TIOCEXCL);
  ::tcflush(file.get(), TCIOFLUSH);
  return {file.release(), path};
}

DeviceStream DeviceStream::connect_tcp(const std::string& host, std::uint16_t port, double patience) {
  const std::string name = host + ":" + std::to_string(port);
  const Deadline deadline(patience);
  const Addresses addresses = look_up(host, port, deadline, name);
  int error = ETIMEDOUT;
  for (const addrinfo* address = addresses.get(); address; address = address->ai_next) {
    File file(::socket(address->ai_family, address->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, address->ai_protocol));
    error = file.get() < 0 ? errno : connect_within(file.get(), *address, deadline);
    if (error != 0) continue;
    send_at_once(file.get());
    return {file.release(), name};
  }
  fail_to_connect(name, error, patience);
}

DeviceStream::DeviceStream(int file, std::string name) : file_(file), name_(std::move(name)) {
  struct stat status{};
  is_socket_ = ::fstat(file_, &status) == 0 && S_ISSOCK(status.st_mode);
  owner_ = ::getpid();
  wake_ = ::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  if (wake_ >= 0) return;
  const int error = errno;
  close();
  fail(name_, "cannot be opened: " + reason(error));
}

DeviceStream::DeviceStream(DeviceStream&& other) noexcept { *this = std::move(other); }

DeviceStream& DeviceStream::operator=(DeviceStream&& other) noexcept {
  if (this == &other) return *this;
  close();
  file_ = std::exchange(other.file_, -1);
  wake_ = std::exchange(other.wake_, -1);
  owner_ = other.owner_;
  is_socket_ = other.is_socket_;
  name_ = std::move(other.name_);
  return *this;
}

DeviceStream::~DeviceStream() { close(); }

void DeviceStream::close() {
  if (file_ >= 0 && !is_socket_ && owner_ == ::getpid()) {  // what a forked process inherited is not its own
    // By hand: both would stay for as long as a forked process, or the other end of a pty, keeps the port open.
    ::ioctl(file_, TIOCNXCL);
    ::flock(file_, LOCK_UN);
  }
  if (file_ >= 0) ::close(std::exchange(file_, -1));
  if (wake_ >= 0) ::close(std::exchange(wake_, -1));
}

std::size_t DeviceStream::read(std::uint8_t* bytes, std::size_t most, double patience) {
  require(most > 0, "a read of 0 bytes would never end");
  const Deadline deadline(patience);
  do {
    pollfd wait[] = {{file_, POLLIN, 0}, {wake_, POLLIN, 0}};
    if (deadline.poll(wait, 2) == 0) continue;
    if (wait[1].revents != 0 && is_interrupted()) return 0;
    if (wait[0].revents == 0) continue;
    if (const std::size_t count = read_some(bytes, most, (wait[0].revents & ~POLLIN) != 0)) return count;
  } while (!deadline.is_over());
  return 0;
}

// -> 0 where another try may succeed.
std::size_t DeviceStream::read_some(std::uint8_t* bytes, std::size_t most, bool hung_up) {
  const ssize_t count = ::read(file_, bytes, most);
  if (count > 0) return static_cast<std::size_t>(count);
  if (count == 0) lose(0);
  if (!try_again(errno) || hung_up) lose(errno);
  return 0;
}

bool DeviceStream::is_interrupted() {
  std::uint64_t times = 0;
  return ::read(wake_, &times, sizeof times) == sizeof times;
}

void DeviceStream::write(const std::uint8_t* bytes, std::size_t count, double patience) {
  const Deadline deadline(patience);
  std::size_t written = 0;
  while (written < count) {
    pollfd wait{file_, POLLOUT, 0};
    if (deadline.poll(&wait, 1) > 0)
      written += write_some(bytes + written, count - written, (wait.revents & ~POLLOUT) != 0);
    if (written == count || !deadline.is_over()) continue;
    ::tcflush(file_, TCOFLUSH);  // else closing the port would go on waiting for it
    fail(name_, "took only " + std::to_string(written) + " of " + std::to_string(count) + " bytes within " +
                    seconds(patience) + "; it hangs: switch it off and on");
  }
}

// -> 0 where another try may succeed.
std::size_t DeviceStream::write_some(const std::uint8_t* bytes, std::size_t count, bool hung_up) {
  const ssize_t written = is_socket_ ? ::send(file_, bytes, count, MSG_NOSIGNAL) : ::write(file_, bytes, count);
  if (written >= 0) return static_cast<std::size_t>(written);
  if (!try_again(errno) || hung_up) lose(errno);
  return 0;
}

void DeviceStream::lose(int error) const {
  const std::string why = error == 0 || try_again(error) ? "" : " (" + reason(error) + ")";
  if (is_socket_) fail(name_, "the connection is lost" + why + "; check the device's power and its cable");
  fail(name_, "the device is gone" + why + "; plug it in again");
}

void DeviceStream::discard_input() {
  if (!is_socket_) {
    ::tcflush(file_, TCIFLUSH);
    return;
  }
  int waiting = 0;
  ::ioctl(file_, FIONREAD, &waiting);  // no more than that, or a device that floods would never let it end
  std::vector<std::uint8_t> unread(static_cast<std::size_t>(waiting));
  if (waiting > 0) [[maybe_unused]]
    const ssize_t dropped = ::read(file_, unread.data(), unread.size());
}

void DeviceStream::interrupt() {
  const std::uint64_t once = 1;
  [[maybe_unused]] const ssize_t written = ::write(wake_, &once, sizeof once);
}

}  // namespace lfdcore
