#include "lfdcore/hardware/device_stream.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>
#include <thread>
#include <vector>

#include "lfdcore/error.hpp"
#include "listener.hpp"
#include "pty.hpp"

namespace lfdcore {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double long_enough = 30;  // [s] that nothing here waits for unless it fails

std::string error_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const DeviceError& error) {
    return error.what();
  }
  return "no error";
}

testing::AssertionResult says(const std::string& text, const std::string& part) {
  if (text.find(part) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "'" << text << "' does not say '" << part << "'";
}

std::string read(DeviceStream& stream, std::size_t count, double patience = long_enough) {
  std::string text;
  while (text.size() < count) {
    std::uint8_t bytes[4096];
    const std::size_t got = stream.read(bytes, std::min(sizeof bytes, count - text.size()), patience);
    if (got == 0) break;
    text.append(reinterpret_cast<const char*>(bytes), got);
  }
  return text;
}

void write(DeviceStream& stream, const std::string& text, double patience = long_enough) {
  stream.write(reinterpret_cast<const std::uint8_t*>(text.data()), text.size(), patience);
}

std::string all_bytes() {
  std::string bytes(256, '\0');
  std::iota(bytes.begin(), bytes.end(), '\0');
  return bytes;
}

double processor_time() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

std::size_t open_files() {
  const std::filesystem::directory_iterator files("/proc/self/fd");
  return static_cast<std::size_t>(std::distance(begin(files), end(files)));
}

TEST(SerialStream, carries_every_byte_unchanged_both_ways) {
  Pty pty;
  DeviceStream stream = DeviceStream::open_serial(pty.path(), 115200);
  pty.say(all_bytes());
  EXPECT_EQ(read(stream, 256), all_bytes());
  write(stream, all_bytes());
  EXPECT_EQ(pty.hear(256), all_bytes());
}

TEST(SerialStream, runs_at_the_rate_asked_for_without_flow_control) {
  Pty pty;
  const DeviceStream stream = DeviceStream::open_serial(pty.path(), 19200);
  const termios settings = pty.settings();
  EXPECT_EQ(::cfgetospeed(&settings), speed_t{B19200});
  EXPECT_EQ(settings.c_cflag & CSIZE, tcflag_t{CS8});
  EXPECT_EQ(settings.c_cflag & (PARENB | CSTOPB | CRTSCTS), 0u);
  EXPECT_EQ(settings.c_iflag & (IXON | IXOFF), 0u);
}

TEST(SerialStream, refuses_a_rate_that_no_port_knows) {
  Pty pty;
  EXPECT_THROW(DeviceStream::open_serial(pty.path(), 115201), std::invalid_argument);
}

TEST(SerialStream, says_which_ports_there_are_when_the_named_one_is_missing) {
  const std::string error = error_of([] { DeviceStream::open_serial("/dev/ttyACM77", 115200); });
  EXPECT_TRUE(says(error, "/dev/ttyACM77: there is no such device"));
  EXPECT_TRUE(says(error, "serial ports here: "));
}

TEST(SerialStream, is_taken_while_another_holds_it_and_free_afterwards) {
  Pty pty;
  {
    const DeviceStream holder = DeviceStream::open_serial(pty.path(), 115200);
    EXPECT_TRUE(says(error_of([&] { DeviceStream::open_serial(pty.path(), 115200); }),
                     pty.path() + ": taken by another program"));
  }
  DeviceStream stream = DeviceStream::open_serial(pty.path(), 115200);
  pty.say("x");
  EXPECT_EQ(read(stream, 1), "x");
}

TEST(SerialStream, frees_the_port_also_while_a_forked_process_lives) {
  Pty pty;
  auto holder = std::make_unique<DeviceStream>(DeviceStream::open_serial(pty.path(), 115200));
  const pid_t child = ::fork();
  if (child == 0) {
    ::pause();
    ::_exit(0);
  }
  holder.reset();
  EXPECT_EQ(error_of([&] { DeviceStream::open_serial(pty.path(), 115200); }), "no error");
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
}

TEST(SerialStream, names_the_group_that_has_permission) {
  Pty pty;
  ASSERT_EQ(::chmod(pty.path().c_str(), 0), 0);
  const uid_t self = ::geteuid();
  ASSERT_EQ(::seteuid(self == 0 ? 65534 : self), 0);  // root may open everything
  const std::string error = error_of([&] { DeviceStream::open_serial(pty.path(), 115200); });
  ASSERT_EQ(::seteuid(self), 0);
  EXPECT_TRUE(says(error, pty.path() + ": no permission"));
  EXPECT_TRUE(says(error, "dialout"));
}

TEST(SerialStream, refuses_what_is_no_serial_port) {
  for (const char* path : {"/dev/null", "/tmp", "/proc/self/exe"})
    EXPECT_TRUE(says(error_of([&] { DeviceStream::open_serial(path, 115200); }), path)) << path;
  EXPECT_TRUE(says(error_of([] { DeviceStream::open_serial("/dev/null", 115200); }), "not a serial port"));
}

TEST(SerialStream, tells_a_reader_that_waits_that_the_device_was_unplugged) {
  Pty pty;
  DeviceStream stream = DeviceStream::open_serial(pty.path(), 115200);
  std::thread unplug([&] { pty.unplug(); });
  EXPECT_TRUE(says(error_of([&] { read(stream, 1, infinity); }), pty.path() + ": the device is gone"));
  unplug.join();
  EXPECT_TRUE(says(error_of([&] { write(stream, "x"); }), pty.path() + ": the device is gone"));
}

TEST(SerialStream, gives_up_a_device_that_takes_nothing) {
  Pty pty;
  DeviceStream stream = DeviceStream::open_serial(pty.path(), 115200);
  const std::string error = error_of([&] { write(stream, std::string(1'000'000, 'x'), 0.05); });
  EXPECT_TRUE(says(error, pty.path() + ": took only"));
  EXPECT_TRUE(says(error, "of 1000000 bytes within 0.05 s"));
}

TEST(SerialStream, forgets_what_came_before_it_was_opened_and_what_is_discarded) {
  Pty pty;
  DeviceStream stream = DeviceStream::open_serial(pty.path(), 115200);
  pty.say("old");
  EXPECT_EQ(read(stream, 1), "o");  // the rest has arrived, too
  stream.discard_input();
  pty.say("new");
  EXPECT_EQ(read(stream, 3), "new");
}

TEST(SerialStream, sleeps_while_nothing_comes) {
  Pty pty;
  DeviceStream stream = DeviceStream::open_serial(pty.path(), 115200);
  const double before = processor_time();
  EXPECT_EQ(read(stream, 1, 0.3), "");
  EXPECT_LT(processor_time() - before, 0.03);
}

TEST(SerialStream, waits_no_longer_for_signals_that_come_meanwhile) {
  struct sigaction action{}, old{};
  action.sa_handler = [](int) {};  // without SA_RESTART: calls end with EINTR
  ::sigaction(SIGALRM, &action, &old);
  const itimerval often{{0, 2000}, {0, 2000}}, never{};
  ::setitimer(ITIMER_REAL, &often, nullptr);
  Pty pty;
  DeviceStream stream = DeviceStream::open_serial(pty.path(), 115200);
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(error_of([&] { EXPECT_EQ(read(stream, 1, 0.1), ""); }), "no error");
  EXPECT_GE(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(100));
  ::setitimer(ITIMER_REAL, &never, nullptr);
  ::sigaction(SIGALRM, &old, nullptr);
}

TEST(SerialStream, wakes_a_reader_from_any_thread_and_the_next_one_if_none_waits) {
  Pty pty;
  DeviceStream stream = DeviceStream::open_serial(pty.path(), 115200);
  std::uint8_t byte = 0;
  std::thread wake([&] { stream.interrupt(); });
  EXPECT_EQ(stream.read(&byte, 1, infinity), 0u);
  wake.join();
  pty.say("x");
  EXPECT_EQ(read(stream, 1), "x") << "interrupted once, not for ever";
  stream.interrupt();
  EXPECT_EQ(stream.read(&byte, 1, infinity), 0u);
}

TEST(SerialStream, is_interrupted_even_while_the_device_floods) {
  Pty pty;
  DeviceStream stream = DeviceStream::open_serial(pty.path(), 115200);
  pty.say(std::string(1000, 'x'));
  stream.interrupt();
  std::uint8_t byte = 0;
  EXPECT_EQ(stream.read(&byte, 1, infinity), 0u);
}

TEST(SerialStream, goes_on_with_its_new_owner_and_leaks_no_file) {
  Pty pty;
  const std::size_t before = open_files();
  for (int i = 0; i < 1000; ++i) {
    DeviceStream first = DeviceStream::open_serial(pty.path(), 115200);
    DeviceStream stream = std::move(first);
    first = std::move(stream);
    ASSERT_EQ(first.name(), pty.path());
  }
  EXPECT_TRUE(says(error_of([] { DeviceStream::open_serial("/dev/null", 115200); }), "not a serial port"));
  EXPECT_EQ(open_files(), before);
}

TEST(SerialStream, refuses_a_patience_that_is_none) {
  Pty pty;
  DeviceStream stream = DeviceStream::open_serial(pty.path(), 115200);
  std::uint8_t byte = 0;
  EXPECT_THROW(stream.read(&byte, 1, std::nan("")), std::invalid_argument);
  EXPECT_THROW(stream.read(&byte, 1, -1), std::invalid_argument);
  EXPECT_THROW(stream.read(&byte, 0, 1), std::invalid_argument);
}

TEST(TcpStream, carries_every_byte_unchanged_both_ways) {
  Listener listener;
  DeviceStream stream = DeviceStream::connect_tcp("localhost", listener.port(), long_enough);
  const int device = listener.accept();
  EXPECT_EQ(stream.name(), "localhost:" + std::to_string(listener.port()));
  write(stream, all_bytes());
  std::string heard(256, ' ');
  EXPECT_EQ(::recv(device, heard.data(), heard.size(), MSG_WAITALL), 256);
  EXPECT_EQ(heard, all_bytes());
  EXPECT_EQ(::send(device, heard.data(), heard.size(), 0), 256);
  EXPECT_EQ(read(stream, 256), all_bytes());
  ::close(device);
}

TEST(TcpStream, says_that_nobody_listens) {
  Listener listener;
  listener.close();
  const std::string error = error_of([&] { DeviceStream::connect_tcp("127.0.0.1", listener.port(), long_enough); });
  EXPECT_TRUE(says(error, "127.0.0.1:" + std::to_string(listener.port())));
  EXPECT_TRUE(says(error, "refuses the connection"));
}

TEST(TcpStream, says_that_nobody_answers_in_time) {
  const Listener listener(0);  // whose queue one connection fills
  const DeviceStream first = DeviceStream::connect_tcp("127.0.0.1", listener.port(), long_enough);
  EXPECT_TRUE(says(error_of([&] { DeviceStream::connect_tcp("127.0.0.1", listener.port(), 0.05); }),
                   "no answer within 0.05 s"));
}

TEST(TcpStream, says_that_the_host_is_unknown) {
  const std::string error = error_of([] { DeviceStream::connect_tcp("no.such.host.invalid", 10940, long_enough); });
  EXPECT_TRUE(says(error, "no.such.host.invalid:10940: unknown host"));
  EXPECT_TRUE(says(error, "IP address"));
}

TEST(TcpStream, says_that_the_connection_is_lost) {
  Listener listener;
  DeviceStream stream = DeviceStream::connect_tcp("127.0.0.1", listener.port(), long_enough);
  ::close(listener.accept());
  EXPECT_TRUE(says(error_of([&] { read(stream, 1, infinity); }), "the connection is lost"));
  EXPECT_TRUE(says(error_of([&] {
                     for (int i = 0; i < 100; ++i) write(stream, std::string(100'000, 'x'));
                   }),
                   "the connection is lost"));
}

TEST(TcpStream, forgets_what_is_discarded) {
  Listener listener;
  DeviceStream stream = DeviceStream::connect_tcp("127.0.0.1", listener.port(), long_enough);
  const int device = listener.accept();
  ASSERT_EQ(::send(device, "old", 3, 0), 3);
  EXPECT_EQ(read(stream, 1), "o");
  stream.discard_input();
  stream.discard_input();
  ASSERT_EQ(::send(device, "new", 3, 0), 3);
  EXPECT_EQ(read(stream, 3), "new");
  ::close(device);
}

}  // namespace
}  // namespace lfdcore
