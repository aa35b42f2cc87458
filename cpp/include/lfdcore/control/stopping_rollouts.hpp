// All that a chair may do while it follows given commands and then brakes: the extreme roll-outs.
#pragma once

#include <array>
#include <span>
#include <utility>
#include <vector>

#include "lfdcore/motion.hpp"

namespace lfdcore {

/// A command and for how long it acts [s].
struct TimedTwist {
  Twist2 twist;
  double duration = 0;
};

/// How far a chair may differ from what is declared, as shares.
struct MotionErrors {
  double dynamics = 0;  ///< of each acceleration and of the braking: quicker or slower
  double speed = 0;     ///< of each speed over ground, against odometry and command
};

/// A piece of a roll-out with a constant twist.
struct RolloutArc {
  Pose2 start;
  Twist2 twist;
  double duration = 0;  ///< [s]
};

/// The motions of a chair that has a twist now, then obeys commands, each for its time, and the last one for between
/// `follow` and `follow` + `jitter` [s]; then it brakes to a standstill.
///
/// Each of its two speeds changes towards what is commanded (`approach`), at rates that lie anywhere within the errors
/// and may change at any time. So each speed lies, at any time, between that of the highest and of the lowest course it
/// can take: a rate or a command that is higher at some time never makes a speed lower later (comparison of ordinary
/// differential equations of first order). The roll-outs combine highest and lowest linear with highest and lowest
/// angular speed. Where the chair drives straight on, or turns on the spot, to one side, the farthest of them
/// holds all others; where it does both, the motions in between end between the four (docs/safety.md).
///
/// Keeps its memory: no allocation once it has seen the longest roll-out.
class StoppingRollouts {
 public:
  StoppingRollouts() = default;
  /// The errors must lie in [0, 0.9].
  StoppingRollouts(const MotionLimits& limits, const MotionErrors& errors) : limits_(limits), errors_(errors) {}

  /// `current`: the twist now; `pending`: the commands that act, one after the other, before any new one.
  void start(const Twist2& current, std::span<const TimedTwist> pending);

  /// From now on the roll-outs end with this command, followed for between `follow` and `follow` + `jitter` [s].
  void end_with(const Twist2& command, double follow, double jitter);

  /// Time [s] from now until the chair surely stands.
  double duration() const;

  /// The longest way [m] and the widest turn to both sides together [rad] until then.
  double travel() const { return most(linear_); }
  double turning() const { return most(angular_); }

  /// How many roll-outs there are: 1, 2 or 4.
  int count() const { return count_; }

  /// The arcs of roll-out i, the one that goes farthest first; the last one stands still. Valid until the next call.
  const std::vector<RolloutArc>& arcs(int i);

 private:
  // The highest and the lowest course of a speed: the means in each step; what they are at the end.
  struct Band {
    std::vector<double> highest, lowest;
    double high = 0, low = 0;

    void cut_to(std::size_t steps);
    bool is_one_course() const { return highest == lowest; }
    bool is_one_sided() const;
    bool is_at_rest() const;
  };
  // How fast a speed changes.
  struct Rates {
    double speeding_up, slowing_down;
  };

  void follow(const Twist2& low, const Twist2& high, double duration);
  void advance(Band& band, const Rates& rates, double low, double high, double duration) const;
  double most(const Band& band) const;
  double time_to_stop() const;
  void choose();

  MotionLimits limits_;
  MotionErrors errors_;
  std::vector<double> steps_;  // [s]
  Band linear_, angular_;
  // When the new command begins to act:
  std::size_t started_ = 0;
  Twist2 started_low_, started_high_;
  int count_ = 1;
  std::array<std::pair<const double*, const double*>, 4> chosen_{};  // mean speeds of the roll-outs
  std::vector<RolloutArc> arcs_;
};

}  // namespace lfdcore
