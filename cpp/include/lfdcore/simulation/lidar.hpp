// The simulated LIDAR: its beams and the noise on them.
#pragma once

#include <cstdint>
#include <span>

#include "lfdcore/geometry.hpp"

namespace lfdcore {

/// Defaults: the chair's LIDAR as the thesis uses it (Sec. 3.2), forward, 180 degrees in steps of one.
struct LidarConfig {
  int beams = 181;
  double field_of_view = pi;  ///< from the first beam to the last, symmetric about ahead [rad]
  double range_max = 30.0;    ///< [m]
  double noise_sd = 0.01;     ///< of each range [m]
  Pose2 T_base_laser{0.70, 0, 0};

  double angle_min() const { return beams == 1 ? 0 : -field_of_view / 2; }
  double angle_increment() const { return field_of_view / std::max(1, beams - 1); }
};

/// Throws std::invalid_argument, naming the field, for a value that is not finite or out of its range.
void validate(const LidarConfig& lidar);

/// Independent streams of random numbers.
enum class NoiseStream : std::uint64_t { scan = 1, slip = 2 };

/// Standard normal numbers that depend on seed, stream, index and place alone, not on what was drawn before: so every
/// arm of a study meets the same noise. Counter-based (SplitMix64, Steele et al. 2014) with Box-Muller.
class Noise {
 public:
  Noise(std::uint64_t seed, NoiseStream stream, std::uint64_t index);
  float normal(std::size_t place) const;

 private:
  std::uint64_t key_;
};

/// Adds noise number `index` of `seed` to the finite ranges: cut at 0, and infinity beyond range_max.
void add_range_noise(const LidarConfig& lidar, std::uint64_t seed, std::uint64_t index, std::span<float> ranges);

}  // namespace lfdcore
