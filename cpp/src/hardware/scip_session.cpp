#include "scip_session.hpp"

#include <algorithm>
#include <chrono>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

constexpr double answer_time = 0.5;    // [s] in which a device answers
constexpr double greeting_time = 0.2;  // [s] the same, for a command that it need not know
constexpr int attempts = 3;            // an answer may be damaged
constexpr int exchanges = 10;          // of times, of which the fastest counts

}  // namespace

double host_now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

ScipSession::ScipSession(DeviceStream stream, const std::atomic<bool>& stopping)
    : stream_(std::move(stream)), stopping_(stopping) {}

bool ScipSession::greet() {
  stream_.discard_input();
  const auto any = [](const ScipReply&) { return true; };
  // A device in SCIP 1.1 changes over; one that still measures or tells its time for a program that is gone, stops.
  for (const char* command : {"SCIP2.0", "TM2"}) ask(command, greeting_time, any);
  for (int attempt = 0; attempt < attempts; ++attempt) {
    if (ask("QT", answer_time, [](const ScipReply& reply) { return reply.status == "00"; })) return true;
    if (bytes_ == 0) break;
  }
  return false;
}

std::string ScipSession::heard() const {
  return bytes_ == 0 ? "it says nothing" : "it says " + std::to_string(bytes_) + " bytes, but no answer";
}

void ScipSession::start() {
  require_scip_2();
  demand("PP", [this](const ScipReply& reply) {
    parameters_ = parse_scip_parameters(reply);
    return true;
  });
  read_clock();
  switch_on();
  measure_ = measure_command(parameters_);
  demand(measure_, "99");
}

void ScipSession::require_scip_2() {
  std::string protocol;
  demand("VV", [&](const ScipReply& reply) {
    const auto fields = parse_scip_fields(reply);
    const auto found = fields.find("PROT");
    protocol = found == fields.end() ? "none that it names" : found->second;
    return true;
  });
  if (!protocol.starts_with("SCIP 2"))
    throw DeviceError(name() + ": its protocol is " + protocol + ", must be SCIP 2.0; update its firmware");
}

void ScipSession::read_clock() {
  int told = 0;
  demand("TM0", "02");
  for (int i = 0; i < exchanges; ++i) {
    const double asked = host_now();
    if (ask("TM1", answer_time, [&](const ScipReply& reply) {
          clock_.exchange(parse_scip_time(reply), asked, host_now());
          return true;
        })) {
      ++told;
      continue;
    }
    // A late answer would be taken for the next one's, its time for a later one. It comes before those to these.
    demand("TM2", "03");
    demand("TM0", "02");
  }
  if (told == 0) throw DeviceError(name() + ": does not tell its time");
  demand("TM2", "03");
}

void ScipSession::switch_on() {
  try {
    demand("BM", "02");
  } catch (const DeviceError& error) {
    throw DeviceError(error.what() + state());
  }
}

// What the device says of its own state, for a message.
std::string ScipSession::state() {
  std::string stat;
  ask("II", answer_time, [&](const ScipReply& reply) {
    const auto fields = parse_scip_fields(reply);
    if (const auto found = fields.find("STAT"); found != fields.end()) stat = " (it says: " + found->second + ")";
    return true;
  });
  return stat;
}

void ScipSession::send(const std::string& command) {
  const std::string line = command + "\n";
  stream_.write(reinterpret_cast<const std::uint8_t*>(line.data()), line.size(), answer_time);
}

std::optional<std::string_view> ScipSession::next_reply(double deadline) {
  for (;;) {
    if (const auto reply = replies_.next()) return reply;
    const double patience = deadline - host_now();
    if (patience <= 0) return std::nullopt;
    std::uint8_t bytes[4096];
    const std::size_t count = stream_.read(bytes, sizeof bytes, patience);
    if (stopping_) throw DeviceError(name() + ": closed");
    replies_.add(bytes, count);
    bytes_ += count;
  }
}

// Whether the command's reply came within `patience` [s], undamaged, and `use` takes it.
bool ScipSession::ask(const std::string& command, double patience, const Use& use) {
  send(command);
  const double deadline = host_now() + patience;
  while (const auto text = next_reply(deadline)) {
    if (text->substr(0, text->find('\n')) != command) continue;  // what was asked for before
    try {
      return use(parse_scip_reply(*text));
    } catch (const DataError&) {
      return false;
    }
  }
  return false;
}

void ScipSession::demand(const std::string& command, const Use& use) {
  std::string refusal = "no answer";
  for (int attempt = 0; attempt < attempts; ++attempt) {
    const bool done = ask(command, answer_time, [&](const ScipReply& reply) {
      refusal = said(command, reply.status);
      return use(reply);
    });
    if (done) return;
  }
  throw DeviceError(name() + ": does not do " + command + ": " + refusal);
}

// Accepted, or a status that means that it is so already.
void ScipSession::demand(const std::string& command, std::string_view also) {
  demand(command, [&](const ScipReply& reply) { return reply.status == "00" || reply.status == also; });
}

std::optional<std::string_view> ScipSession::next_measurement(double patience) {
  const double deadline = host_now() + patience;
  while (const auto text = next_reply(deadline)) {
    if (text->starts_with(measure_)) return text;
    ++strange_;
  }
  return std::nullopt;
}

void ScipSession::quit() noexcept {
  try {
    send("QT");
  } catch (const DeviceError&) {
    // It is gone, and its laser with it.
  }
}

std::string ScipSession::said(std::string_view command, std::string_view status) {
  return "status " + std::string(status) + ": " + scip_status_meaning(command, status);
}

}  // namespace lfdcore
