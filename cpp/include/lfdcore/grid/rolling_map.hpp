// A map of recent scans that travels with the robot: it covers what the LIDAR no longer sees.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "lfdcore/grid/fused_points.hpp"
#include "lfdcore/grid/grid.hpp"
#include "lfdcore/grid/laser_scan.hpp"
#include "lfdcore/grid/obstacle_points.hpp"
#include "lfdcore/grid/seen_cells.hpp"

namespace lfdcore {

struct RollingMapConfig {
  double duration = 30.0;             ///< how long points and free cells are remembered [s]
  double radius = 4.0;                ///< how far from the robot obstacles() looks [m], 0.5 to 20
  double range_noise = 0.01;          ///< standard deviation of a range [m], 0.001 to 0.2
  double odometry_error = 0.0;        ///< share of way and turn by which the odometry may be wrong, 0 to 0.5
  std::optional<Footprint> own_body;  ///< the robot's outline: hits inside it are its own (a foot on its rest)
};

/// Throws std::invalid_argument, naming the field and its bound.
void validate(const RollingMapConfig& config);

/// Fused points (FusedPoints) and seen cells (SeenCells) aligned with the odometry frame, in a square of at least
/// 10 x 10 m around the robot.
///
/// A point is forgotten
/// - `duration` after its last hit, or when the square leaves it behind;
/// - when beams go on behind it, by more than 3 standard errors: one that passes within 0.004 m of it and goes on by 15
///   times that distance more (a wall under a grazing beam does the same), while the beam on its other side hits
///   nothing within 0.25 m of it (else a surface ends there), or two on both sides of it, at most 0.03 m
///   apart. Once for a point of 1 or 2 hits within 5 standard deviations of a surer one (noise), in 3 scans without a
///   hit between for others. Where the odometry's error may have moved it by more than 0.015 m, it must have been hit
///   there, or beams go on behind the other places too;
/// - 3 s after its last hit, if it is young: if it stands where beams had passed, surely and densely, all around within
///   the last 3 s, and no point that has stood for 1 s lies within 0.06 m (less than 1 s, where the odometry's error
///   would make a thing that stands there walk). So a person who walks out of view is
///   forgotten, and what comes into view from behind a corner is not. What is hit for 3 s without moving is no longer
///   young.
///
/// Hits deeper inside `own_body` than `own_depth` are the robot's own: no obstacle, and their beam says nothing.
class RollingMap {
 public:
  static constexpr double own_depth = 0.03;  ///< [m] inside the outline: what is hit deeper is the robot's own

  explicit RollingMap(const RollingMapConfig& config = {});

  /// Adds a scan taken at `stamp` [s]; one without beams is as one whose beams all measured nothing. Allocates nothing
  /// once its buffers have grown to the scan's size. Throws std::invalid_argument, and changes nothing, for an invalid
  /// scan, a pose that is not finite or farther than 1e7 m, or a stamp before the last one (an equal one, of a second
  /// LIDAR, is accepted).
  void insert(double stamp, const LaserScan& scan, const Pose2& T_base_laser, const Pose2& T_odom_base);

  /// The remembered points within `radius` of base_link, in base_link, each with 3 standard errors as its uncertainty.
  ///
  /// With an `odometry_error`, a point is given with the ends of where it may lie by now: what this share of the way
  /// driven since its hits (their mean), and of the turns, each about where it was made, moves it by. So a point beside
  /// a straight drive moves along the drive, not sideways. Ends nearer than 5 mm are left out.
  ///
  /// Within 2 m, neighbours 0.03 to 0.25 m apart are one surface, seen at a grazing angle: points fill the line between
  /// them, at most 0.03 m apart, as uncertain as the more uncertain end.
  ObstaclePoints obstacles(const Pose2& T_odom_base) const;

  /// The remembered points, in base_link, of what walks: young ones that the newest scan hit, with 3 standard
  /// errors as their uncertainty. obstacles() holds them too.
  ObstaclePoints walkers(const Pose2& T_odom_base) const;

  /// The edge of the space that nothing is known of: the centres, in base_link, of the cells of 0.05 m that no beam has
  /// passed or ended in within `duration`, or since the odometry's error may have come to 0.1 m, next to ones that are
  /// known, no farther from the outline of `body` than `reach` [m]. Within 0.1 m ahead of or behind it: of all such
  /// cells of 0.025 m, with half their diagonal as their uncertainty. What lies under the body is known, and what was
  /// under `own_body` in any of the scans. Gaps of less than 0.25 m, as between the beams of a scan, count as seen, but
  /// not within 0.25 m of a point: there they are the inside and the far side of a thing. Throws std::invalid_argument
  /// for a pose that is not finite, a footprint beyond 100 m or a reach outside [0, 20] m.
  ObstaclePoints unseen(const Pose2& T_odom_base, const Footprint& body, double reach) const;

  /// The window around base_link, 100 x 100 cells: occupied where a remembered point lies, else free where the cell
  /// under one of its quarters' centres was seen free within `duration`, else unknown.
  OccupancyGrid local_grid(const Pose2& T_odom_base) const;

  /// Forgets everything, stamps included.
  void clear();

  /// Points remembered.
  std::size_t size() const { return points_.points().size(); }
  const RollingMapConfig& config() const { return config_; }

 private:
  struct Ray {
    double dx, dy, length;
    bool hit;
  };
  // A scan's stamp, and the odometry's way until then: place, turn and the sum of turn x place [m, rad, m rad].
  struct Taken {
    double stamp, x, y, turn = 0, turn_x = 0, turn_y = 0;
  };
  struct Shift {
    double x, y;
  };
  // A point as the laser has it [m], how far a beam must go on behind it, and the nearest beams that do on both sides.
  struct Passing {
    double dx, dy, noise;
    double left = std::numeric_limits<double>::infinity(), right = left;
  };

  void count_scan(double stamp, const Pose2& T_odom_base);
  void forget_old_stamps(double stamp);
  double odometry_error(const Taken& then) const;
  Taken at(double stamp, const Pose2& T_odom_base) const;
  const Taken& taken(ScanNumber scan) const { return taken_[taken_.size() - 1 - (last_scan_ - scan)]; }
  ScanNumber oldest_scan() const { return last_scan_ + 1 - static_cast<ScanNumber>(taken_.size() - first_taken_); }

  void read_rays(const LaserScan& scan, const Pose2& T_base_laser, double yaw);
  bool own(const Pose2& T_base_laser, double angle, double length) const;
  void add_hits(const Pose2& T_odom_laser);
  double walked_since_last_scan(double distance) const;
  double settled_for(double walked) const;
  bool is_young(const FusedPoint& point, double walked) const;
  void mark_free(const Pose2& T_odom_laser);
  void drop_stale(const LaserScan& scan, const Pose2& T_odom_laser);
  bool is_noise(const FusedPoint& point) const;
  bool is_gone(const FusedPoint& point, const LaserScan& scan, const Pose2& T_odom_laser);
  bool seen_through(const FusedPoint& point, const LaserScan& scan, const Pose2& T_odom_laser) const;
  bool ends_at(const Passing& passing, std::size_t i, double left) const;
  bool any_through(Passing& passing, std::size_t from, std::size_t to) const;

  void fill_gaps(const Pose2& T_odom_base, std::vector<FusedPoint>& points) const;
  void find_places(const FusedPoint& point, double error, const Taken& now, std::vector<Shift>& places) const;
  void add_odometry_errors(const FusedPoint& point, const Taken& now, std::vector<Shift>& places) const;
  Mask unknown_around(const Pose2& T_odom_base, const Footprint& body, Eigen::Index side, double corner_x,
                      double corner_y) const;
  void add_unseen_quarters(const Eigen::Vector2d& centre, const Pose2& T_base_odom, const Footprint& body,
                           std::vector<double>& points) const;
  Mask with_points(Eigen::Index side, double corner_x, double corner_y) const;

  RollingMapConfig config_;
  SeenCells cells_;
  FusedPoints points_;
  std::vector<Ray> rays_;
  std::vector<Shift> places_;
  std::vector<Taken> taken_;  // of the scans not older than duration, from first_taken_ on
  std::size_t first_taken_ = 0;
  // recent: the first of the last few seconds; sure: the first since which odometry cannot be much wrong
  ScanNumber last_scan_ = 0, recent_scan_ = 1, sure_scan_ = 1;
  double last_yaw_ = 0;
};

}  // namespace lfdcore
