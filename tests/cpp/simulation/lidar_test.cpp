#include "lfdcore/simulation/lidar.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace lfdcore {
namespace {

std::vector<double> numbers(std::uint64_t seed, NoiseStream stream, std::uint64_t index, std::size_t count) {
  const Noise noise(seed, stream, index);
  std::vector<double> drawn(count);
  for (std::size_t i = 0; i < count; ++i) drawn[i] = noise.normal(i);
  return drawn;
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum / static_cast<double>(a.size());
}

TEST(Noise, is_standard_normal_in_its_first_four_moments) {
  constexpr std::size_t count = 200000;
  const auto drawn = numbers(5, NoiseStream::scan, 3, count);
  double mean = 0, second = 0, third = 0, fourth = 0;
  for (const double n : drawn) {
    mean += n / count;
    second += n * n / count;
    third += n * n * n / count;
    fourth += n * n * n * n / count;
  }
  EXPECT_NEAR(mean, 0, 4 / std::sqrt(count));
  EXPECT_NEAR(second, 1, 4 * std::sqrt(2.0 / count));
  EXPECT_NEAR(third, 0, 4 * std::sqrt(15.0 / count));
  EXPECT_NEAR(fourth, 3, 4 * std::sqrt(96.0 / count));
}

TEST(Noise, is_uncorrelated_between_neighbouring_seeds_streams_indices_and_places) {
  constexpr std::size_t count = 100000;
  const double bound = 4 / std::sqrt(count);
  const auto base = numbers(8, NoiseStream::scan, 40, count);
  EXPECT_NEAR(correlation(base, numbers(9, NoiseStream::scan, 40, count)), 0, bound);
  EXPECT_NEAR(correlation(base, numbers(8, NoiseStream::slip, 40, count)), 0, bound);
  EXPECT_NEAR(correlation(base, numbers(8, NoiseStream::scan, 41, count)), 0, bound);
  std::vector<double> next(base.begin() + 1, base.end());
  EXPECT_NEAR(correlation(next, std::vector<double>(base.begin(), base.end() - 1)), 0, bound);
}

TEST(Noise, depends_on_its_four_coordinates_alone) {
  const Noise noise(1, NoiseStream::scan, 2);
  const float late = noise.normal(77);
  EXPECT_EQ(Noise(1, NoiseStream::scan, 2).normal(77), late);
}

TEST(AddRangeNoise, leaves_misses_alone_and_cuts_at_zero_and_at_range_max) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  LidarConfig lidar;
  lidar.noise_sd = 0.5;
  lidar.range_max = 5;
  std::vector<float> ranges;
  for (int i = 0; i < 300; ++i) ranges.insert(ranges.end(), {infinity, 0.01f, 4.99f});
  add_range_noise(lidar, 1, 1, ranges);
  int at_zero = 0, beyond = 0;
  for (std::size_t i = 0; i < ranges.size(); i += 3) {
    EXPECT_EQ(ranges[i], infinity);
    EXPECT_GE(ranges[i + 1], 0);
    EXPECT_TRUE(ranges[i + 2] <= 5 || ranges[i + 2] == infinity);
    at_zero += ranges[i + 1] == 0;
    beyond += ranges[i + 2] == infinity;
  }
  EXPECT_NEAR(at_zero, 150, 40);
  EXPECT_NEAR(beyond, 150, 40);
}

}  // namespace
}  // namespace lfdcore
