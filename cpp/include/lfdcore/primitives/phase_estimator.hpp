// How far a partner has come in a movement, and how fast (Sec. 5.3.1, Eq. 5.5 with ERRATA 38, F14).
#pragma once

#include <span>
#include <vector>

#include "lfdcore/primitives/open_end_dtw.hpp"

namespace lfdcore {

struct PhaseEstimatorConfig {
  double phase_decay = 4.605170185988092;  ///< alpha_x > 0 of the DMPs' canonical system, ln 100
  double tempo_window = 0.5;               ///< the rate is of the last [s], 0 < .. <= 60
  double rest_share = 0.05;                ///< no further from its start than this share of the way is rest, (0, 1)
  double pause_rate = 0.15;                ///< slower than this share of the reference's tempo is a pause, [0, 1)
};

/// Throws std::invalid_argument, naming the field and its bounds.
void validate(const PhaseEstimatorConfig& config);

struct PartnerPhase {
  int index = -1;             ///< t* - 1, row of the reference; -1 before any sample
  double distance = 0;        ///< of the open-end DTW
  double reference_time = 0;  ///< of that row [s]
  double phase = 1;           ///< x* = exp(-alpha_x (t* - 1) / (n - 1))
  double rate = 1;            ///< the partner's tempo now, 1 = the reference's, >= 0; 1 until known
  double mean_rate = 1;       ///< reference_time / time since the first sample: tau = t*/T' of F14; 1 until determined
  bool determined = false;    ///< false while partner or reference still rest at their start: then index says nothing
  bool paused = false;        ///< the partner stands still (or has come to the end)
};

/// Open-end DTW gives t*: it does not care about tempo, a pausing partner leaves it where it is. The rate is the slope
/// of t* over the last `tempo_window`: the line through the medians of its first and its last third, so that single
/// jumps of t* do not count. It follows a change of tempo within about one window. The phase is determined, for good,
/// once partner and reference have both gone further from their starts than `rest_share` of the reference's greatest
/// distance from its own. Sample the reference about as densely as the partner: many more rows make t* lag, since each
/// row passed over adds its distance. One caller at a time.
class PhaseEstimator {
 public:
  /// reference (n, D) evenly sampled over `duration` [s]. Throws std::invalid_argument for n < 2, what is not finite
  /// and within 1e100, a reference that never leaves its start, and a duration that is not > 0.
  PhaseEstimator(const RowMatrix& reference, double duration, const PhaseEstimatorConfig& config = {});

  /// The partner's sample (D,) at `stamp` [s]; NaN as in OpenEndDtw: one without any seen dimension changes nothing but
  /// the clock. No allocation. Throws std::invalid_argument, and stays as it was, for a stamp that is not finite or not
  /// later than the last and for samples that OpenEndDtw refuses.
  const PartnerPhase& observe(double stamp, std::span<const double> sample);
  void reset();  ///< forgets all samples

  const PartnerPhase& phase() const { return phase_; }
  int size() const { return dtw_.size(); }              ///< n
  int dimensions() const { return dtw_.dimensions(); }  ///< D
  double duration() const { return duration_; }         ///< [s]
  const PhaseEstimatorConfig& config() const { return config_; }

 private:
  bool has_left_start(std::span<const double> sample);
  void remember(double stamp, double reference_time);
  double slope();

  PhaseEstimatorConfig config_;
  OpenEndDtw dtw_;
  double duration_, rest_distance_ = 0;
  int first_moving_ = 0;             // row of the reference that is the first beyond rest_distance_
  double first_stamp_, last_stamp_;  // -inf before any sample
  std::vector<double> start_;        // the partner's, NaN where not seen yet
  bool left_start_ = false;
  std::vector<double> stamps_, times_, scratch_;  // rings: the window's samples, at most 512
  std::size_t oldest_ = 0, held_ = 0;
  PartnerPhase phase_;
};

}  // namespace lfdcore
