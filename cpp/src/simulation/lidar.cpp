#include "lfdcore/simulation/lidar.hpp"

#include <limits>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

constexpr std::uint64_t golden = 0x9e3779b97f4a7c15;

std::uint64_t mixed(std::uint64_t z) {
  z += golden;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return z ^ (z >> 31);
}

/// In (0, 1], from the lower 24 bits.
float uniform(std::uint64_t bits) { return (static_cast<float>(bits & 0xffffff) + 1) * 0x1p-24f; }

}  // namespace

void validate(const LidarConfig& lidar) {
  require_between("beams", lidar.beams, 1, 100000, "beams");
  require_between("field_of_view", lidar.field_of_view, 1e-6, 2 * pi, "rad");
  require_positive("range_max", lidar.range_max, "m");
  require_between("noise_sd", lidar.noise_sd, 0, 10, "m");
  require_between("T_base_laser.x", lidar.T_base_laser.x, -10, 10, "m");
  require_between("T_base_laser.y", lidar.T_base_laser.y, -10, 10, "m");
  require_finite("T_base_laser.yaw", lidar.T_base_laser.yaw, "rad");
}

Noise::Noise(std::uint64_t seed, NoiseStream stream, std::uint64_t index)
    : key_(mixed(mixed(mixed(seed) ^ static_cast<std::uint64_t>(stream)) ^ index)) {}

float Noise::normal(std::size_t place) const {
  const std::uint64_t bits = mixed(key_ + place * golden);
  return std::sqrt(-2 * std::log(uniform(bits))) * std::cos(static_cast<float>(2 * pi) * uniform(bits >> 32));
}

void add_range_noise(const LidarConfig& lidar, std::uint64_t seed, std::uint64_t index, std::span<float> ranges) {
  if (lidar.noise_sd == 0) return;
  const Noise noise(seed, NoiseStream::scan, index);
  const auto sd = static_cast<float>(lidar.noise_sd), longest = static_cast<float>(lidar.range_max);
  for (std::size_t beam = 0; beam < ranges.size(); ++beam) {
    const float noisy = std::max(0.0f, ranges[beam] + sd * noise.normal(beam));
    ranges[beam] = noisy > longest ? std::numeric_limits<float>::infinity() : noisy;
  }
}

}  // namespace lfdcore
