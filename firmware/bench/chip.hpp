// An ATmega328P at 16 MHz in simavr: its time, its resets, and hooks into its registers.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "simavr/sim_avr.h"
#include "simavr/sim_io.h"

namespace bench {

using Cycles = avr_cycle_count_t;  // of the chip's clock since it was first powered

constexpr Cycles cycles_per_us = 16;
// Fuses of an Arduino Uno: 65 ms and 16 K cycles of the crystal pass between the end of a reset and the first
// instruction.
constexpr Cycles start_up = 65'000 * cycles_per_us + 16'384 + 14;

enum class Reset { power, external, brown_out, watchdog };
const char* name_of(Reset cause);

class Chip;

/// Calls back at a cycle. It keeps time through resets of the chip, as what lies outside does; a part of the chip
/// cancels its alarms at a reset.
class Alarm {
 public:
  Alarm(Chip& chip, std::function<void(Cycles)> callback);
  Alarm(const Alarm&) = delete;
  Alarm& operator=(const Alarm&) = delete;

  void set(Cycles when);
  void cancel();
  bool is_set() const { return set_; }
  Cycles when() const { return when_; }

 private:
  friend class Chip;
  static Cycles fire(avr_t* avr, Cycles when, void* alarm);
  void arm();

  Chip& chip_;
  std::function<void(Cycles)> callback_;
  Cycles when_ = 0;
  bool set_ = false;
};

class Chip {
 public:
  /// Loads the firmware and powers the chip. Throws std::runtime_error for a file that is no firmware for it.
  explicit Chip(const std::string& elf);
  ~Chip();
  Chip(const Chip&) = delete;
  Chip& operator=(const Chip&) = delete;

  Cycles now() const { return avr_->cycle; }
  /// Runs until `end`; a few cycles more where an instruction or an interrupt goes over it.
  void run_until(Cycles end);

  void reset(Reset cause);
  void power_off();
  void power_on();
  /// Test aid: the program goes into an endless loop, and its interrupts with it unless they are `served`. Throws
  /// std::invalid_argument where it does not run.
  void hang(bool served);

  bool powered() const { return powered_; }
  bool running() const { return powered_ && !held_.is_set(); }
  unsigned resets(Reset cause) const { return resets_[static_cast<int>(cause)]; }
  unsigned crashes() const { return crashes_; }

  uint8_t& at(uint16_t address) { return avr_->data[address]; }
  avr_t* avr() { return avr_; }
  /// One of the chip's parts in simavr, by its name there.
  template <typename Part>
  Part& part(const char* kind) {
    return *reinterpret_cast<Part*>(find_part(kind));
  }

  void on_read(uint16_t address, std::function<uint8_t()> read);
  /// Instead of what simavr does.
  void on_write(uint16_t address, std::function<void(uint8_t)> write);
  /// After what simavr does.
  void after_write(uint16_t address, std::function<void()> then);
  /// After the registers were set to their initial values.
  void on_reset(std::function<void()> hook) { reset_hooks_.push_back(std::move(hook)); }
  /// Before the registers are cleared by a failure of the power.
  void on_power_off(std::function<void()> hook) { power_hooks_.push_back(std::move(hook)); }
  void on_reset_begin(std::function<void(Reset)> tell) { tell_reset_ = std::move(tell); }

  void raise(avr_int_vector_t& vector) { avr_raise_interrupt(avr_, &vector); }
  /// Clears its flag, too.
  void lower(avr_int_vector_t& vector);
  /// A level, not an edge: it comes again after its handler as long as `still` says so.
  void keep_raised(avr_int_vector_t& vector, std::function<bool()> still);

 private:
  friend class Alarm;
  struct Write {
    std::function<void(uint8_t)> replace;
    std::function<void()> then;
    avr_io_write_t before = nullptr;
    void* before_param = nullptr;
  };
  struct Level {
    Chip* chip;
    avr_int_vector_t* vector;
    std::function<bool()> still;
  };

  avr_io_t* find_part(const char* kind);
  void step();
  void idle(Cycles end);
  void set_initial_values();
  void release();
  void note_crash();
  static uint8_t read_hook(avr_t* avr, avr_io_addr_t address, void* read);
  static void write_hook(avr_t* avr, avr_io_addr_t address, uint8_t value, void* write);
  static void level_hook(avr_irq_t* irq, uint32_t running, void* level);

  avr_t* avr_;
  avr_run_t run_;
  std::vector<Alarm*> alarms_;
  std::vector<std::unique_ptr<std::function<uint8_t()>>> reads_;
  std::vector<std::unique_ptr<Write>> writes_;
  std::vector<std::unique_ptr<Level>> levels_;
  std::vector<std::function<void()>> reset_hooks_, power_hooks_;
  std::function<void(Reset)> tell_reset_;
  Alarm end_, held_;  // held_: in reset until then
  uint8_t reset_flags_ = 0;
  bool powered_ = true, dead_ = false;
  unsigned resets_[4] = {}, crashes_ = 0;
};

}  // namespace bench
