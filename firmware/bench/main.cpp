// joystick_bench: runs the firmware of the joystick interface on a simulated chip, and is all that is around it.
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>

#include "commands.hpp"
#include "pty.hpp"

namespace {

using bench::Bench;
using bench::Cycles;
using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

constexpr int misused = 2;
constexpr std::size_t waiting_for_line = 16;  // bytes taken from the pty before their time
constexpr Seconds most_behind(0.05);          // that may be caught up with
constexpr Cycles grain = 1000 * bench::cycles_per_us;
constexpr double longest_run = 3600e6;  // [us]
constexpr std::size_t longest_line = 65536;

struct Arguments {
  std::string elf, eeprom;
  bool free = false;
};

[[noreturn]] void misuse(const std::string& why) {
  std::fprintf(stderr, "joystick_bench: %s\nusage: joystick_bench ELF [--eeprom FILE] [--free]\n\n%s", why.c_str(),
               bench::command_help);
  std::exit(misused);
}

Arguments read_arguments(int count, char** words) {
  Arguments arguments;
  for (int k = 1; k < count; ++k) {
    const std::string word = words[k];
    if (word == "--free")
      arguments.free = true;
    else if (word == "--eeprom" && k + 1 < count)
      arguments.eeprom = words[++k];
    else if (word.rfind("--", 0) == 0 || !arguments.elf.empty())
      misuse("unexpected '" + word + "'");
    else
      arguments.elf = word;
  }
  if (arguments.elf.empty()) misuse("no firmware is named");
  return arguments;
}

// Lines of standard input, as they come.
class Input {
 public:
  /// Waits for more, but not longer than `timeout` [ms], -1 for ever; false at its end.
  bool wait(int timeout) {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (poll(&input, 1, timeout) <= 0) return true;
    std::array<char, 4096> chunk;
    const ssize_t size = read(STDIN_FILENO, chunk.data(), chunk.size());
    if (size > 0) text_.append(chunk.data(), static_cast<std::size_t>(size));
    if (text_.size() > longest_line && text_.find('\n') == std::string::npos)
      throw std::runtime_error("a command of more than 64 KiB");
    return size > 0 || (size < 0 && errno == EINTR);
  }

  bool take(std::string& line) {
    const std::size_t end = text_.find('\n');
    if (end == std::string::npos) return false;
    line = text_.substr(0, end);
    text_.erase(0, end + 1);
    return true;
  }

 private:
  std::string text_;
};

class Session {
 public:
  explicit Session(const Arguments& arguments)
      : free_(arguments.free),
        pty_(free_ ? nullptr : std::make_unique<bench::Pty>()),
        bench_(
            arguments.elf, arguments.eeprom, [this](Cycles when, uint8_t byte) { received(when, byte); },
            [this](Cycles when, const std::string& what) {
              if (traced_) tell(when, what.c_str());
            }) {}

  void run() {
    std::printf("PTY %s\n", free_ ? "none" : pty_->path().c_str());
    std::fflush(stdout);
    free_ ? run_free() : run_paced();
    bench_.eeprom.save();
  }

 private:
  void received(Cycles when, uint8_t byte) {
    if (pty_) return pty_->write(byte);
    if (!free_) return;  // unplugged
    char text[8];
    std::snprintf(text, sizeof text, "uart %02x", byte);
    tell(when, text);
  }

  void tell(Cycles when, const char* what) { std::printf("@%s %s\n", bench::microseconds(when).c_str(), what); }

  void run_free() {
    while (input_.wait(-1)) answer_all();
  }

  // Time follows the clock on the wall in steps of 1 ms. Where the machine was too slow, what is lost stays lost: the
  // chip must not hear the PC in slow motion and then run after it.
  void run_paced() {
    begin_ = Clock::now();
    while (input_.wait(milliseconds_until(wall_of(bench_.chip.now())))) {
      answer_all();
      const Seconds behind = Clock::now() - wall_of(bench_.chip.now());
      if (behind < Seconds(0)) continue;
      if (behind > most_behind) begin_ += std::chrono::duration_cast<Clock::duration>(behind - most_behind);
      step();
    }
  }

  Clock::time_point wall_of(Cycles when) const {
    const Seconds passed(static_cast<double>(when) / (1e6 * bench::cycles_per_us));
    return begin_ + std::chrono::duration_cast<Clock::duration>(passed);
  }

  void step() {
    exchange();
    bench_.chip.run_until(bench_.chip.now() + grain);
    exchange();
    bench_.eeprom.save();
    std::fflush(stdout);
  }

  static int milliseconds_until(Clock::time_point when) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(when - Clock::now());
    return static_cast<int>(std::max<long long>(0, left.count()));
  }

  void exchange() {
    if (!pty_) return;
    pty_->flush();
    if (bench_.line.waiting() >= waiting_for_line) return;
    for (const char byte : pty_->read(waiting_for_line)) bench_.line.send(static_cast<uint8_t>(byte));
  }

  void answer_all() {
    for (std::string line; input_.take(line);) {
      std::printf("%s\n", answer(line).c_str());
      std::fflush(stdout);
    }
  }

  std::string answer(const std::string& line) try {
    const bench::Words words(line);
    if (words.size() > 0 && words.word(0) == "trace") return trace(words);
    if (words.size() > 0 && words.word(0) == "run") return pass_time(words);
    if (words.size() > 0 && words.word(0) == "send") return send(words);
    if (words.size() > 0 && words.word(0) == "usb") return plug(words);
    return bench::carry_out(bench_, line);
  } catch (const std::invalid_argument& error) {
    return std::string("error ") + error.what();
  }

  std::string trace(const bench::Words& words) {
    words.expect(2, "trace on|off");
    traced_ = words.choice(1, "off", "on");
    return "ok";
  }

  std::string plug(const bench::Words& words) {
    words.expect(2, "usb unplug|plug");
    if (free_) throw std::invalid_argument("with --free there is no port to unplug");
    const bool plugged = words.choice(1, "unplug", "plug");
    if (plugged && !pty_) pty_ = std::make_unique<bench::Pty>();
    if (!plugged) pty_.reset();
    return plugged ? "PTY " + pty_->path() : "ok";
  }

  void expect_free(const bench::Words& words) const {
    if (!free_) throw std::invalid_argument("'" + words.word(0) + "' is for a bench started with --free");
  }

  std::string pass_time(const bench::Words& words) {
    words.expect(2, "run MICROSECONDS");
    expect_free(words);
    due_ += static_cast<Cycles>(std::llround(words.number(1, "MICROSECONDS", 0, longest_run) * bench::cycles_per_us));
    bench_.chip.run_until(due_);
    bench_.eeprom.save();
    return "ok";
  }

  std::string send(const bench::Words& words) {
    words.expect(2, "send HEX");
    expect_free(words);
    const std::string& hex = words.word(1);
    if (hex.size() % 2 || hex.find_first_not_of("0123456789abcdefABCDEF") != std::string::npos)
      throw std::invalid_argument("HEX is '" + hex + "', must be two hexadecimal digits a byte");
    for (std::size_t k = 0; k < hex.size(); k += 2)
      bench_.line.send(static_cast<uint8_t>(std::stoi(hex.substr(k, 2), nullptr, 16)));
    return "ok";
  }

  bool free_, traced_ = false;
  std::unique_ptr<bench::Pty> pty_;
  Bench bench_;
  Input input_;
  Cycles due_ = 0;
  Clock::time_point begin_;  // on the wall, of the chip's time
};

}  // namespace

int main(int count, char** words) try {
  std::signal(SIGPIPE, SIG_IGN);
  Session(read_arguments(count, words)).run();
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "joystick_bench: %s\n", error.what());
  return 1;
}
