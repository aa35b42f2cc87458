// A chair with odometry and a LIDAR, driven through a map in control periods.
#pragma once

#include <cstdint>
#include <vector>

#include "lfdcore/grid/laser_scan.hpp"
#include "lfdcore/grid/ray_casting.hpp"
#include "lfdcore/simulation/contact_response.hpp"
#include "lfdcore/simulation/lidar.hpp"

namespace lfdcore {

/// What one control period led to.
struct StepResult {
  Pose2 pose;                      ///< T_map_base, true
  Twist2 twist;                    ///< of the wheels at the end, after any contact
  Pose2 odometry;                  ///< T_odom_base, as the encoders have it; starts at (0, 0, 0)
  Twist2 odometry_twist;           ///< as the encoders have it
  bool in_contact = false;         ///< touching, or not yet clear of the last contact
  bool collision_started = false;  ///< a contact began in this period
};

/// The truth about the chair, for drivers and metrics, not for assistants.
struct ChairState {
  double stamp = 0;  ///< since the reset [s]
  Pose2 pose;        ///< T_map_base
  Twist2 twist;
  bool in_contact = false;
  int collisions = 0;                       ///< contacts begun since the reset
  double distance = 0;                      ///< travelled by the axle's centre since the reset [m]
  Eigen::Vector2d contact_point{NAN, NAN};  ///< of the last collision: centre of the touched cell [m]; NaN before
};

class DrivingWorld {
 public:
  /// The chair stands nowhere until reset(). `unknown_is_solid`: unknown cells and all outside the map stop the chair
  /// and the LIDAR's beams alike (real buildings); else both pass. Throws std::invalid_argument for a bad config.
  DrivingWorld(const OccupancyGrid& grid, const ChairConfig& chair, const LidarConfig& lidar, std::uint64_t seed,
               bool unknown_is_solid = true);

  /// Puts the chair at rest at T_map_base, with odometry, counters, clock and noise as new. Throws
  /// std::invalid_argument for a pose that is not finite or touches an obstacle, saying where.
  void reset(const Pose2& pose);

  /// Drives towards the command for `duration` [s], at most 10; a command beyond the limits is cut to them. The body
  /// never touches a solid cell afterwards. Throws std::invalid_argument for values that are not finite or before a
  /// reset.
  StepResult step(const Twist2& command, double duration = 0.1);

  /// What the LIDAR sees now. Its noise depends on the seed and the number of steps since the reset alone.
  LaserScan scan() const;
  /// The same without allocating, into a scan that this world made.
  void scan(LaserScan& scan) const;

  /// True if the footprint, grown by a margin [m], of a chair at T_map_base touches a solid cell.
  bool touches(const Pose2& pose, double margin = 0) const;

  ChairState state() const { return state_; }
  Pose2 odometry() const { return odometry_; }
  const ChairConfig& chair() const { return chair_; }
  const LidarConfig& lidar() const { return lidar_; }

 private:
  struct PendingCommand {
    double stamp;  // when it acts
    Twist2 command;
  };

  void sub_step(double duration);
  void note_contact(const BodyMotion& motion, double duration);
  void draw_slip();

  ChairConfig chair_;
  LidarConfig lidar_;
  std::uint64_t seed_;
  SolidMap map_;
  RayCaster rays_;
  std::vector<double> angles_;  // of the beams [rad]
  ChairState state_;
  bool placed_ = false;
  std::uint64_t steps_ = 0;
  double clear_time_ = 0;
  double skid_ = 0;  // sideways speed left over from a contact [m/s]
  std::vector<PendingCommand> pending_;
  Twist2 acting_;
  Pose2 odometry_;
  double linear_factor_ = 1, angular_factor_ = 1;
};

}  // namespace lfdcore
