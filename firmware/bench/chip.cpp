#include "chip.hpp"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "registers.hpp"
#include "simavr/avr_extint.h"
#include "simavr/avr_watchdog.h"
#include "simavr/sim_elf.h"

namespace bench {

namespace {

constexpr uint16_t endless_loop = 0xCFFF;  // rjmp .-2
constexpr uint16_t first_ram = 0x100;

void log_to_stderr(avr_t*, const int level, const char* format, va_list arguments) {
  if (level <= LOG_ERROR) std::vfprintf(stderr, format, arguments);
}

void never_sleep(avr_t*, Cycles) {}  // the bench keeps the time

uint8_t flag_of(Reset cause) {
  constexpr uint8_t flags[] = {PORF, EXTRF, BORF, WDRF};
  return flags[static_cast<int>(cause)];
}

avr_t* make_chip(const std::string& elf) {
  elf_firmware_t firmware = {};
  if (elf_read_firmware(elf.c_str(), &firmware) || !firmware.flashsize)
    throw std::runtime_error(elf + " is not an AVR firmware (an ELF file that avr-gcc made)");
  avr_t* avr = avr_make_mcu_by_name("atmega328p");
  avr_init(avr);
  if (firmware.flashbase + firmware.flashsize > avr->flashend - 1)
    throw std::runtime_error(elf + " does not fit into the flash of an ATmega328P with room for the bench's loop");
  firmware.frequency = 1'000'000 * cycles_per_us;
  firmware.vcc = firmware.avcc = firmware.aref = 5000;
  avr_load_firmware(avr, &firmware);
  avr->log = LOG_ERROR;
  std::memcpy(avr->flash + avr->flashend - 1, &endless_loop, sizeof endless_loop);
  return avr;
}

}  // namespace

const char* name_of(Reset cause) {
  constexpr const char* names[] = {"power", "external", "brown_out", "watchdog"};
  return names[static_cast<int>(cause)];
}

Alarm::Alarm(Chip& chip, std::function<void(Cycles)> callback) : chip_(chip), callback_(std::move(callback)) {
  chip.alarms_.push_back(this);
}

void Alarm::set(Cycles when) {
  when_ = when;
  set_ = true;
  arm();
}

void Alarm::arm() {
  const Cycles now = chip_.now();
  avr_cycle_timer_register(chip_.avr_, when_ > now ? when_ - now : 0, fire, this);
}

void Alarm::cancel() {
  if (set_) avr_cycle_timer_cancel(chip_.avr_, fire, this);
  set_ = false;
}

Cycles Alarm::fire(avr_t*, Cycles, void* self) {
  auto* alarm = static_cast<Alarm*>(self);
  alarm->set_ = false;
  alarm->callback_(alarm->when_);
  return 0;
}

Chip::Chip(const std::string& elf)
    : avr_((avr_global_logger_set(log_to_stderr), make_chip(elf))),
      run_(avr_->run),
      end_(*this, [](Cycles) {}),
      held_(*this, [](Cycles) {}) {
  avr_->sleep = never_sleep;
}

Chip::~Chip() { avr_terminate(avr_); }

avr_io_t* Chip::find_part(const char* kind) {
  for (avr_io_t* io = avr_->io_port; io; io = io->next)
    if (!std::strcmp(io->kind, kind)) return io;
  throw std::runtime_error(std::string("this simavr has no ") + kind + " in its ATmega328P");
}

void Chip::run_until(Cycles end) {
  end_.set(end);
  while (now() < end) step();
  end_.cancel();
}

void Chip::step() {
  if (running() && avr_->run != run_) return reset(Reset::watchdog);
  if (!running() || dead_) return idle(end_.when());
  avr_->run(avr_);
  if (avr_->state != cpu_Running && avr_->state != cpu_Sleeping) note_crash();
}

// Time passes without an instruction: no power, in reset, or the core has stopped for good.
void Chip::idle(Cycles end) {
  const bool held = held_.is_set();
  const Cycles next = avr_cycle_timer_process(avr_);
  if (held && !held_.is_set()) return release();
  avr_->cycle += std::clamp<Cycles>(next, 1, std::max<Cycles>(end, now() + 1) - now());
}

// Asleep with interrupts off, or an invalid instruction: only a reset goes on from there.
void Chip::note_crash() {
  dead_ = true;
  ++crashes_;
}

void Chip::set_initial_values() {
  avr_->run = run_;
  avr_reset(avr_);
  avr_->run_cycle_limit = 100'000;  // simavr may run that long between its timers
  // else simavr looks at a low INT0 or INT1 pin every cycle, also where the program does not use that interrupt
  for (uint8_t interrupt = 0; interrupt < 2; ++interrupt) avr_extint_set_strict_lvl_trig(avr_, interrupt, 0);
  for (Alarm* alarm : alarms_)
    if (alarm->set_) alarm->arm();
  for (const auto& hook : reset_hooks_) hook();
  dead_ = false;
}

void Chip::reset(Reset cause) {
  if (!powered_) return;
  reset_flags_ = static_cast<uint8_t>((cause == Reset::power ? 0 : at(MCUSR)) | flag_of(cause));
  ++resets_[static_cast<int>(cause)];
  part<avr_watchdog_t>("watchdog").reset_context.wdrf = 0;  // it starts when the reset ends
  set_initial_values();
  held_.set(now() + start_up);
  if (tell_reset_) tell_reset_(cause);
}

void Chip::release() {
  auto& watchdog = part<avr_watchdog_t>("watchdog");
  watchdog.reset_context.wdrf = reset_flags_ & WDRF ? 1 : 0;
  watchdog.reset_context.avr_run = run_;
  set_initial_values();
  at(MCUSR) = reset_flags_;
}

void Chip::power_off() {
  if (!powered_) return;
  held_.cancel();
  for (const auto& hook : power_hooks_) hook();
  part<avr_watchdog_t>("watchdog").reset_context.wdrf = 0;
  set_initial_values();
  powered_ = false;
}

void Chip::power_on() {
  if (powered_) return;
  powered_ = true;
  uint32_t noise = 0x2545F491;
  for (unsigned k = 0; k <= avr_->ramend; ++k) {
    noise ^= noise << 13, noise ^= noise >> 17, noise ^= noise << 5;
    if (k < 32 || k >= first_ram) at(static_cast<uint16_t>(k)) = static_cast<uint8_t>(noise);
  }
  reset(Reset::power);
}

void Chip::hang(bool served) {
  if (!running()) throw std::invalid_argument("the chip does not run: it is in reset, or has no power");
  avr_->pc = avr_->flashend - 1;
  avr_->state = cpu_Running;
  if (served) return;
  avr_->sreg[S_I] = 0;
  avr_->interrupt_state = 0;
}

void Chip::on_read(uint16_t address, std::function<uint8_t()> read) {
  reads_.push_back(std::make_unique<std::function<uint8_t()>>(std::move(read)));
  avr_->io[AVR_DATA_TO_IO(address)].r = {reads_.back().get(), read_hook};
}

void Chip::on_write(uint16_t address, std::function<void(uint8_t)> write) {
  writes_.push_back(std::make_unique<Write>(Write{std::move(write), {}}));
  avr_->io[AVR_DATA_TO_IO(address)].w = {writes_.back().get(), write_hook};
}

void Chip::after_write(uint16_t address, std::function<void()> then) {
  auto& slot = avr_->io[AVR_DATA_TO_IO(address)].w;
  writes_.push_back(std::make_unique<Write>(Write{{}, std::move(then), slot.c, slot.param}));
  slot = {writes_.back().get(), write_hook};
}

uint8_t Chip::read_hook(avr_t* avr, avr_io_addr_t address, void* read) {
  return avr->data[address] = (*static_cast<std::function<uint8_t()>*>(read))();
}

void Chip::write_hook(avr_t* avr, avr_io_addr_t address, uint8_t value, void* self) {
  const auto* write = static_cast<Write*>(self);
  if (write->replace) return write->replace(value);
  if (write->before)
    write->before(avr, address, value, write->before_param);
  else
    avr->data[address] = value;
  write->then();
}

void Chip::lower(avr_int_vector_t& vector) {
  avr_clear_interrupt(avr_, &vector);
  avr_regbit_clear(avr_, vector.raised);
}

void Chip::keep_raised(avr_int_vector_t& vector, std::function<bool()> still) {
  levels_.push_back(std::make_unique<Level>(Level{this, &vector, std::move(still)}));
  avr_irq_register_notify(vector.irq + AVR_INT_IRQ_RUNNING, level_hook, levels_.back().get());
}

void Chip::level_hook(avr_irq_t*, uint32_t running, void* self) {
  const auto* level = static_cast<Level*>(self);
  if (!running && level->still()) level->chip->raise(*level->vector);
}

}  // namespace bench
