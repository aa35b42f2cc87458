#include "lfdcore/hardware/scip_clock.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace lfdcore {
namespace {

// A device's clock: it was `start` [ms] at 0 s by the host's clock, and runs at a rate of its own.
struct Crystal {
  double start = 0, rate = 1;
  std::uint32_t at(double time) const {
    return static_cast<std::uint32_t>(std::fmod(std::floor(start + 1e3 * rate * time), 16777216.0));
  }
};

ScipClock synchronised(const Crystal& crystal, double time) {
  ScipClock clock;
  for (int i = 0; i < 10; ++i) {
    const double asked = time + 0.01 * i;
    clock.exchange(crystal.at(asked + 0.0005), asked, asked + 0.001);
  }
  return clock;
}

// The greatest error [s] over `duration` [s] of 25 ms scans that come through after a delay.
double greatest_error(const Crystal& crystal, double duration, const std::function<double(double)>& delay) {
  ScipClock clock = synchronised(crystal, 0);
  double greatest = 0;
  for (double taken = 0.2; taken < duration; taken += 0.025) {
    const double received = taken + delay(taken);
    const auto stamp = clock.host_time(crystal.at(taken), received);
    if (!stamp) return INFINITY;
    EXPECT_LE(*stamp, received);
    greatest = std::max(greatest, std::abs(*stamp - taken));
  }
  return greatest;
}

std::function<double(double)> usual_delay() {
  return [random = std::mt19937(1)](double) mutable {
    return 0.024 + std::exponential_distribution<double>(1 / 0.003)(random);
  };
}

TEST(ScipClock, is_right_by_a_millisecond_or_so) { EXPECT_LT(greatest_error({5000, 1}, 60, usual_delay()), 0.002); }

TEST(ScipClock, goes_on_where_24_bits_end) {
  EXPECT_LT(greatest_error({16777216 - 30000, 1}, 60, usual_delay()), 0.002);
  EXPECT_LT(greatest_error({16777216 - 10, 1}, 60, usual_delay()), 0.002) << "between two exchanges";
}

TEST(ScipClock, follows_a_crystal_that_drifts_for_an_hour) {
  EXPECT_LT(greatest_error({0, 1 + 100e-6}, 3600, usual_delay()), 0.005);
  EXPECT_LT(greatest_error({0, 1 - 100e-6}, 3600, usual_delay()), 0.005);
}

TEST(ScipClock, is_hardly_moved_by_a_host_that_is_late_for_a_while) {
  const auto usual = usual_delay();
  EXPECT_LT(greatest_error({0, 1}, 120, [&](double t) { return usual(t) + (t > 30 && t < 60 ? 0.2 : 0.0); }), 0.012);
}

TEST(ScipClock, never_stamps_after_the_receipt) {
  ScipClock clock;
  clock.exchange(1000, 10.0, 10.08);  // the answer was slow: the offset is late by up to 0.04 s
  EXPECT_EQ(clock.host_time(1000, 10.01), 10.01);
}

TEST(ScipClock, tells_how_long_ago_the_scan_before_was) {
  ScipClock clock = synchronised({16777216 - 1000, 1}, 0);
  clock.host_time(16777216 - 10, 0.99);
  EXPECT_EQ(clock.interval(), 0) << "the first";
  clock.host_time(15, 1.02);
  EXPECT_EQ(clock.interval(), 25);
}

TEST(ScipClock, notices_that_the_device_began_anew) {
  ScipClock clock = synchronised({100000, 1}, 0);
  EXPECT_TRUE(clock.host_time(100200, 0.23));
  EXPECT_FALSE(clock.host_time(50, 0.33)) << "set back";
  EXPECT_FALSE(clock.host_time(105000, 0.35)) << "ahead";
  EXPECT_FALSE(clock.host_time(100300, 1.5)) << "too old";
  EXPECT_TRUE(clock.host_time(100300, 0.33)) << "and forgets what cannot be";
}

}  // namespace
}  // namespace lfdcore
