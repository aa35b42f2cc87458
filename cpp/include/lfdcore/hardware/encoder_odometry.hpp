// Odometry of a differential drive from the edges that its wheels' encoders count.
#pragma once

#include <cstdint>
#include <deque>

#include "lfdcore/geometry.hpp"

namespace lfdcore {

struct WheelEncoders {
  double left_radius = 0, right_radius = 0;  ///< of the wheels [m]
  double track = 0;                          ///< between the wheels [m]
  double edges_per_turn = 0;                 ///< four a line of a quadrature encoder, negative where it counts back
  double window = 0.05;                      ///< [s] over which the twist is the mean
};

/// Throws std::invalid_argument, naming the field: nothing of it has a default that could be another chair's.
void validate(const WheelEncoders& config);

/// Adds up what two encoders count. Counts wrap around at 32 bits.
class EncoderOdometry {
 public:
  explicit EncoderOdometry(const WheelEncoders& config);

  /// Takes counts read at `stamp` [s]. The first ones, and those after reset(), are where it begins. Those of a stamp
  /// that is not later are not taken. Throws std::invalid_argument for a stamp that is not finite.
  void update(double stamp, std::int32_t left, std::int32_t right);
  /// The next counts begin anew: the chip was reset. The pose stays.
  void reset() { counts_.clear(); }

  /// T_odom_base [m, rad].
  const Pose2& pose() const { return pose_; }
  /// [m/s, rad/s], the mean of the last `window`, or since the counts before if these are older.
  const Twist2& twist() const { return twist_; }

 private:
  struct Counts {
    double stamp;
    std::int32_t left, right;
  };

  Twist2 moved(const Counts& from, const Counts& to) const;

  WheelEncoders config_;
  std::deque<Counts> counts_;  // the newest, those of the window, and one that is older
  Pose2 pose_;
  Twist2 twist_;
};

}  // namespace lfdcore
