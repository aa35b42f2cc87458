// The last word before the motors: the command nearest to the wanted one after which the chair can still stop in time.
#pragma once

#include <vector>

#include "lfdcore/control/near_points.hpp"
#include "lfdcore/geometry.hpp"
#include "lfdcore/grid/obstacle_points.hpp"
#include "lfdcore/motion.hpp"

namespace lfdcore {

struct SupervisorConfig {
  double period = 0.1;        ///< until the next command can take effect [s]
  double reaction = 0.2;      ///< until the next command surely has taken effect: period + latency [s]
  double margin = 0.04;       ///< distance to keep between footprint and points [m]
  double slow_margin = 0.03;  ///< the same while slow, so that narrow gaps can be passed [m]
  double slow_linear = 0.2;   ///< slow: |linear| of command and chair at most this [m/s] ...
  double slow_angular = 0.4;  ///< ... and |angular| at most this [rad/s]
  double overlap = 0.02;      ///< points this deep inside the footprint are taken for noise of the scan [m]
  double least_scale = 0.25;  ///< a wanted twist is slowed down to this share before other directions are tried
  int linear_samples = 9;     ///< speeds tried, from the wanted one to 0
  int angular_samples = 17;   ///< turning rates tried, around the wanted one
};

/// Throws std::invalid_argument, naming the field and its bound.
void validate(const SupervisorConfig& config);

struct SupervisorResult {
  Twist2 twist;          ///< the command to send [m/s, rad/s]
  double scale = 1;      ///< its size as a share of the wanted one's (1 if that is 0)
  bool changed = false;  ///< it is not the wanted one
  bool stopped = false;  ///< it is 0 though the wanted one is not
  double margin = 0;     ///< distance [m] that was required; below the configured ones if the chair is nearer already
};

/// Lets commands through that leave the chair able to stop.
///
/// A command is admissible if the chair, starting with its current twist and changing it as `approach` does, follows
/// the command for `period`, and also for `reaction`, and then brakes to a standstill, without any point coming nearer
/// to the footprint than the margin. What braking after `period` passes is what the command 0 passes in the next
/// period, so stopping stays admissible from one command to the next, as long as the points stand still.
/// Motion between the tested poses is bounded, not sampled: nothing is missed by more than 2 mm or a quarter of the
/// margin.
///
/// Where points are already nearer than the margin, the margin is the present clearance, and points that lie deeper
/// inside the footprint than `overlap` must not get deeper: the chair can always drive away from them.
///
/// Search: the wanted twist; its scaled copies (same arc) down to `least_scale`, the largest; then a grid of twists not
/// faster ahead than the wanted one, in the order of their distance to it, hypot(dv / max_linear, dw / max_angular);
/// then 0. Only twists nearer to the wanted one than 0 is are tried: it never moves for the sake of moving.
class Supervisor {
 public:
  /// Throws std::invalid_argument for invalid limits or config, a footprint that is not positive, or limits that
  /// need more than 30 s to stop.
  explicit Supervisor(const Footprint& footprint = {}, const MotionLimits& limits = {},
                      const SupervisorConfig& config = {});

  /// `wanted` beyond the limits is cut to them (and reported as changed). `current` is the chair's twist when the
  /// command takes effect. `obstacles` in base_link; without points everything is admissible, so a caller whose scan is
  /// stale must want 0. Not thread-safe: one supervisor per thread.
  /// Throws std::invalid_argument for a non-finite twist or a current one beyond 10 times the limits.
  SupervisorResult filter(const Twist2& wanted, const Twist2& current, const ObstaclePoints& obstacles);

  const Footprint& footprint() const { return footprint_; }
  const MotionLimits& limits() const { return limits_; }
  const SupervisorConfig& config() const { return config_; }

 private:
  // A short arc of a roll-out. `reach`: no point of the body has moved farther before it [m].
  struct Arc {
    Pose2 start;
    Twist2 twist;
    double duration = 0, reach = 0;
  };
  struct Candidate {
    Twist2 twist;
    double distance = 0;
  };

  bool admissible(const Twist2& command);
  void roll_out(const Twist2& command, double follow);
  Twist2 append(const Twist2& from, const Twist2& command, double duration);
  bool roll_out_is_free();
  bool free_between(double from, double to, double slack_from, double slack_to);
  double reach_at(double place) const;
  double slack_at(double place);
  double margin_for(const Twist2& command) const;
  bool largest_scale(const Twist2& wanted, Twist2& found);
  bool nearest_twist(const Twist2& wanted, Twist2& found);
  void list_candidates(const Twist2& wanted);
  double size(const Twist2& twist) const;

  Footprint footprint_;
  MotionLimits limits_;
  SupervisorConfig config_;
  // Of the call in progress:
  Twist2 current_;
  NearPoints points_;
  double clearance_ = 0, margin_ = 0;
  std::vector<Arc> arcs_;
  std::vector<Candidate> candidates_;
};

}  // namespace lfdcore
