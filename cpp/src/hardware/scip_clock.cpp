#include "lfdcore/hardware/scip_clock.hpp"

#include <algorithm>
#include <cmath>

namespace lfdcore {
namespace {

constexpr std::uint32_t turn = 1u << 24;
constexpr double millisecond = 1e-3;
constexpr double farthest = 1.0;  // [s] that a scan may be away from its receipt
constexpr double ahead = 0.05;    // [s] by which an offset may be wrong

}  // namespace

void ScipClock::exchange(std::uint32_t ticks, double asked, double answered) {
  if (answered - asked >= shortest_) return;
  shortest_ = answered - asked;
  last_ = ticks;
  elapsed_ = 0;
  offset_ = (asked + answered) / 2 - millisecond / 2;  // its count was on average half a tick old
}

std::optional<double> ScipClock::host_time(std::uint32_t ticks, double received) {
  const std::uint32_t passed = (ticks - last_) % turn;
  if (passed > turn / 2) return std::nullopt;
  const double taken = offset_ + millisecond * static_cast<double>(elapsed_ + passed);
  const double delay = received - taken;
  if (delay > farthest || delay < -ahead) return std::nullopt;
  interval_ = began_ ? passed : 0;
  elapsed_ += passed;
  last_ = ticks;
  follow(delay, received);
  began_ = true;
  return std::min(taken, received);
}

void ScipClock::follow(double delay, double received) {
  if (!began_) window_begin_ = received;
  least_ = std::min(least_, delay);
  const double passed = received - window_begin_;
  if (passed < window) return;
  if (usual_) offset_ += std::clamp(least_ - *usual_, -most_drift * passed, most_drift * passed);
  if (!usual_) usual_ = least_;
  window_begin_ = received;
  least_ = std::numeric_limits<double>::infinity();
}

}  // namespace lfdcore
