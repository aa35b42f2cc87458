// A map of recent scans that travels with the robot: it covers what the LIDAR no longer sees.
#pragma once

#include <cstdint>
#include <vector>

#include "lfdcore/grid/grid.hpp"
#include "lfdcore/grid/laser_scan.hpp"
#include "lfdcore/grid/obstacle_points.hpp"

namespace lfdcore {

/// Cells of 0.025 m aligned with the odometry frame, in a square of at least 10 x 10 m around the robot (half the local
/// window's cells: with one point a cell of 0.05 m the near corner of a post can go unremembered). A cell keeps
/// the exact point of its last hit, so that obstacles are not rounded to cells, and when it was last seen free.
///
/// A point is forgotten when it is older than `duration`, when the square leaves it behind, or when a later beam passes
/// within 0.02 m of it and goes on for at least 0.3 m (what stood there has moved), unless the same scan hits its cell.
class RollingMap {
 public:
  /// duration [s] > 0: how long points and free cells are remembered; radius [m] in [0.5, 20]: how far from the robot
  /// obstacles() looks.
  explicit RollingMap(double duration = 30.0, double radius = 4.0);

  /// Adds a scan taken at `stamp` [s]. Allocates nothing once its buffers have grown to the scan's size.
  /// Throws std::invalid_argument, and changes nothing, for an invalid scan, a pose that is not finite or farther than
  /// 1e7 m, or a stamp before the last one (an equal one, of a second LIDAR, is accepted).
  void insert(double stamp, const LaserScan& scan, const Pose2& T_base_laser, const Pose2& T_odom_base);

  /// The remembered points within `radius` of base_link, in base_link.
  ObstaclePoints obstacles(const Pose2& T_odom_base) const;

  /// The window around base_link, 100 x 100 cells: occupied where a remembered point lies, else free where the cell
  /// under one of its quarters' centres was seen free within `duration`, else unknown.
  OccupancyGrid local_grid(const Pose2& T_odom_base) const;

  /// Forgets everything, stamps included.
  void clear();

  /// Points remembered.
  std::size_t size() const { return hits_.size(); }
  double duration() const { return duration_; }
  double radius() const { return radius_; }

 private:
  // Scans are counted from 1; cells refer to them by number, and 0 is never.
  using ScanNumber = std::uint32_t;
  static constexpr std::int64_t outside = -1;
  struct CellState {
    ScanNumber last_free = 0;
    std::int32_t hit = -1;  // index in hits_
  };
  struct Hit {
    double x, y;  // odom [m]
    ScanNumber scan;
    std::uint32_t slot;
  };
  struct Ray {
    double dx, dy, length;
    bool hit;
  };

  void count_scan(double stamp);
  void follow(double x, double y);
  void forget_free_columns(std::int64_t from, std::int64_t to);
  void forget_free_rows(std::int64_t from, std::int64_t to);
  void read_rays(const LaserScan& scan, double yaw);
  void add_hits(const Pose2& T_odom_laser);
  void mark_free(const Pose2& T_odom_laser);
  void drop_stale_hits(const LaserScan& scan, const Pose2& T_odom_laser);
  bool seen_through(const Hit& hit, const LaserScan& scan, const Pose2& T_odom_laser) const;
  bool any_through(const Hit& hit, const Pose2& T_odom_laser, std::size_t from, std::size_t to) const;
  template <class Stale>
  void drop_hits_if(Stale stale);
  std::int64_t slot_at(double x, double y) const;
  ScanNumber oldest_scan() const { return last_scan_ + 1 - static_cast<ScanNumber>(stamps_.size() - first_stamp_); }

  double duration_, radius_;
  int side_;                                    // cells, a power of two
  std::int64_t corner_ix_ = 0, corner_iy_ = 0;  // absolute cell of the square's corner
  std::vector<CellState> cells_;                // a torus: cell (ix, iy) lies at (ix mod side, iy mod side)
  std::vector<Hit> hits_;
  std::vector<Ray> rays_;
  std::vector<double> stamps_;  // of the scans not older than duration, from first_stamp_ on
  std::size_t first_stamp_ = 0;
  ScanNumber last_scan_ = 0;
};

}  // namespace lfdcore
