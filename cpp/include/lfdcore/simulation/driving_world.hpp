// A chair with odometry and a LIDAR, driven through a map among people in control periods.
#pragma once

#include <cstdint>
#include <vector>

#include "lfdcore/grid/laser_scan.hpp"
#include "lfdcore/grid/ray_casting.hpp"
#include "lfdcore/simulation/contact_response.hpp"
#include "lfdcore/simulation/lidar.hpp"
#include "lfdcore/simulation/people.hpp"
#include "lfdcore/simulation/person_contact.hpp"

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

/// The truth about the chair, for drivers and metrics, not for assistants. Its contacts are those with the map.
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

  /// The people from now on, each known by its place in the list: a contact goes on from one list to the next. In step
  /// each walks straight on at its velocity, through whatever is there: they are no walls, neither the chair nor they
  /// are stopped or pushed where they meet, which is counted (person_contacts). Without people everything is as in a
  /// world that never had any, byte by byte. Throws std::invalid_argument for a bad person, or before a reset, which
  /// takes all people away.
  void set_people(std::vector<Person> people);
  const std::vector<Person>& people() const { return people_; }
  /// The contacts with people since the reset, in the order in which they began.
  const std::vector<PersonContact>& person_contacts() const { return person_contacts_.all(); }
  /// Whether any of them is not yet over.
  bool touches_person() const { return person_contacts_.touching(); }
  /// For each person whether a beam of the LIDAR, without noise, meets it first: before the map and other people.
  std::vector<bool> people_in_scan() const;

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
  void walk_people(double duration);
  void cast(std::span<float> ranges, std::span<int> met = {}) const;
  void draw_slip();

  ChairConfig chair_;
  LidarConfig lidar_;
  std::uint64_t seed_;
  SolidMap map_;
  RayCaster rays_;
  std::vector<double> angles_;               // of the beams [rad]
  std::vector<Eigen::Vector2d> directions_;  // of the same
  std::vector<Person> people_;
  PersonContacts person_contacts_;
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
