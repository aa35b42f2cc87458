// The last word before the motors: the command nearest to the wanted one after which the chair can still stop in time.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "lfdcore/control/command_timing.hpp"
#include "lfdcore/control/near_points.hpp"
#include "lfdcore/control/stopping_rollouts.hpp"
#include "lfdcore/geometry.hpp"
#include "lfdcore/grid/obstacle_points.hpp"
#include "lfdcore/motion.hpp"

namespace lfdcore {

struct SupervisorConfig {
  double margin = 0.04;          ///< distance to keep between footprint and points at speed [m]
  double least_margin = 0.015;   ///< ... and at standstill; in between in proportion to the speed [m]
  double margin_linear = 0.5;    ///< speed from which `margin` is kept [m/s] ...
  double margin_angular = 1.0;   ///< ... or turning rate [rad/s]
  double passing_margin = 0.01;  ///< distance beside the way of a chair that creeps straight on [m]
  double dynamics_error = 0.2;   ///< share by which accelerations and braking may differ from the limits
  double speed_error = 0.05;     ///< share by which speeds over ground may differ from odometry and command
  double obstacle_speed = 0;     ///< at which points may come nearer [m/s]
  double walking_speed = 1.5;    ///< ... and those of who walks [m/s]
  double creep_linear = 0.1;     ///< creeping: ahead at most this fast [m/s] ...
  double creep_reverse = 0.15;   ///< ... backwards [m/s] ...
  double creep_angular = 0.2;    ///< ... and turning [rad/s]; so, unseen space may be entered
  double least_scale = 0.75;     ///< a wanted twist is slowed down to this share before other directions are tried
  int linear_samples = 9;        ///< speeds tried, from the wanted one to 0
  int angular_samples = 17;      ///< turning rates tried, around the wanted one
};

/// Throws std::invalid_argument, naming the field and its bound.
void validate(const SupervisorConfig& config);

struct SupervisorResult {
  Twist2 twist;          ///< the command to send [m/s, rad/s]
  double scale = 1;      ///< its stick size as a share of the wanted one's (1 if that is 0)
  bool changed = false;  ///< it is not the wanted one
  bool stopped = false;  ///< it is 0 though the wanted one is not
  bool keeps =
      true;  ///< it is admissible; false: it is 0, and even stopping may bring a point nearer than it has to keep
  double margin = 0;  ///< distance [m] that was required of points that were not nearer already, less uncertainty
};

/// Lets commands through that leave the chair able to stop. What it promises, and on what assumptions: docs/safety.md.
///
/// A command is admissible if no roll-out of it brings a point nearer to the footprint than the point has to keep. The
/// roll-outs (StoppingRollouts) start with the current twist, obey the commands that are pending, then this one for
/// `period`, up to `jitter` longer (CommandTiming), and brake to a standstill, with all that the errors allow. A point
/// has to keep
///
///     least_margin .. margin, by the speed  +  its uncertainty  +  obstacle_speed (its age + time until standstill),
///
/// but never more than the distance that it has now, below 0 inside the footprint: a point that is too near must not
/// come nearer, and says nothing about other points. A chair that creeps straight on may pass points nearer: what is
/// surely beside its way, and a wall that touches its side (SideContact). What braking after `period` passes is what
/// the command 0 passes in the next period. Motion between the tested poses is bounded, not sampled: nothing is missed
/// by more than 2 mm.
///
/// Search: the wanted twist; its scaled copies (same arc) down to `least_scale`, the largest; then the nearest of a
/// grid of twists that may replace it, moved towards it as far as that is admissible; then 0. See `may_replace`.
class Supervisor {
 public:
  /// Throws std::invalid_argument for invalid limits, config or timing, a footprint that is not positive, or limits
  /// that need more than 30 s to stop.
  explicit Supervisor(const Footprint& footprint = {}, const MotionLimits& limits = {},
                      const SupervisorConfig& config = {}, const CommandTiming& timing = {});

  /// `wanted` beyond the limits is cut to them (and reported as changed). `current` is the chair's twist now.
  /// `obstacles` in base_link; without points everything is admissible, so a caller whose scan is stale must want 0.
  /// `pending`: the commands already given that act from now on, before this one does (latency). `age` [s] of the
  /// points: counts with obstacle_speed. `unseen`: places in base_link at the border of space that no beam has seen; a
  /// command faster than the creep speeds is admissible only if its roll-outs keep them out of the footprint.
  /// `walkers`: points of who walks about, in base_link: they may come nearer at `walking_speed`. Not
  /// thread-safe: one supervisor per thread. Throws std::invalid_argument for a twist that is not finite, a current or
  /// pending one beyond 10 times the limits, a duration or an age that is not in [0, 10].
  SupervisorResult filter(const Twist2& wanted, const Twist2& current, const ObstaclePoints& obstacles,
                          std::span<const TimedTwist> pending = {}, double age = 0, const ObstaclePoints& unseen = {},
                          const ObstaclePoints& walkers = {});

  /// Forgets how near the walls were that touch the chair's sides (SideContact). A wanted twist of 0 does so, too.
  void reset();

  /// Whether a twist may stand in for the wanted one (within the limits), as far as the driver is concerned. Where a
  /// turn on the spot is wanted (linear 0): a slower turn to the same side. Else: linear between 0 and the wanted one;
  /// a stick size hypot(linear / max_linear or max_reverse, angular / max_angular) no larger than the wanted one's; not
  /// to the side opposite to the one asked for; nearer to the wanted twist than 0 is: it never moves for the sake of
  /// moving.
  bool may_replace(const Twist2& wanted, const Twist2& twist) const;

  const Footprint& footprint() const { return footprint_; }
  const MotionLimits& limits() const { return limits_; }
  const SupervisorConfig& config() const { return config_; }
  const CommandTiming& timing() const { return timing_; }

 private:
  struct Candidate {
    Twist2 twist;
    double distance = 0;
  };
  // A place on a roll-out: number of the arc + share of it; and the slack there [m].
  struct Place {
    double number, slack;
  };
  struct End {
    Pose2 pose;
    double slack;
  };

  void require_valid(const Twist2& wanted, const Twist2& current, std::span<const TimedTwist> pending,
                     double age) const;
  void look(const Twist2& aim, const Twist2& current, const ObstaclePoints& obstacles,
            std::span<const TimedTwist> pending, const ObstaclePoints& unseen, const ObstaclePoints& walkers);
  bool admissible(const Twist2& command);
  bool creeps(const Twist2& command) const;
  double creep_scale(const Twist2& wanted) const;
  double margin_for(const Twist2& command) const;
  bool stays_clear_of(NearPoints& points, const Demand& demand);
  void measure_reach();
  bool free_along(const Place& from, const Place& to);
  bool free_across(const End& from, const End& to);
  double reach_at(double place) const;
  Pose2 pose_at(double place) const;
  double slack_at(const Pose2& pose);
  Twist2 refined(Twist2 good, Twist2 bad);
  bool largest_scale(const Twist2& wanted, Twist2& found);
  bool nearest_twist(const Twist2& wanted, Twist2& found);
  void list_candidates(const Twist2& wanted);
  void try_later(const Twist2& wanted, const Twist2& twist);
  double size(const Twist2& twist) const;

  Footprint footprint_;
  MotionLimits limits_;
  SupervisorConfig config_;
  CommandTiming timing_;
  // Of the call in progress:
  double age_ = 0, fastest_linear_ = 0, fastest_angular_ = 0;  // of the chair before the new command acts
  NearPoints points_, unseen_, walkers_;
  Sides sides_;  // and of those before it, since the stick was let go
  StoppingRollouts rollouts_;
  std::vector<Candidate> candidates_;
  // Of the test in progress:
  NearPoints* points_tested_ = nullptr;
  Demand demand_;
  const std::vector<RolloutArc>* arcs_ = nullptr;
  std::vector<double> reach_;  // [m] at each arc's start: no point of the body has moved farther before it
  std::array<End, 4> ends_{};
};

}  // namespace lfdcore
