// Obstacles as the points that a LIDAR saw, and how far a rectangular body is from them: exact, without rasterising.
#pragma once

#include <cstdint>
#include <vector>

#include "lfdcore/geometry.hpp"
#include "lfdcore/path.hpp"

namespace lfdcore {

/// Immutable set of points with an index for many queries: built in tens of microseconds from a thousand points, each
/// query looks at few of them and allocates nothing. The answers are those of a loop over all points.
class ObstaclePoints {
 public:
  ObstaclePoints() = default;
  /// Points (M, 2) [m] in any one frame. `uncertainty` (M) [m]: how much nearer than its point each obstacle may be,
  /// e.g. some standard errors of a fused range; empty: 0 for all. Throws std::invalid_argument for points that are not
  /// finite, and for uncertainties that are not in [0, 100] or not as many as the points.
  explicit ObstaclePoints(Path points, std::vector<double> uncertainty = {});

  const Path& points() const { return points_; }
  /// (M) [m]. It is for those who keep a distance (Supervisor); collides() and clearance() are about the points alone.
  const std::vector<double>& uncertainty() const { return uncertainty_; }

  /// True if any point lies inside (or on) the footprint of a body at `pose` (same frame as the points).
  /// Throws std::invalid_argument for a pose or footprint that is not finite.
  bool collides(const Pose2& pose, const Footprint& footprint) const;

  /// Distance [m] from the footprint's edge to the nearest point outside it; 0 if one lies inside; infinity if none.
  /// Throws std::invalid_argument for a pose or footprint that is not finite.
  double clearance(const Pose2& pose, const Footprint& footprint) const;

 private:
  // Inclusive columns and rows of buckets.
  struct Buckets {
    int left, right, bottom, top;
  };

  void lay_out_cells();
  void sort_into_buckets();
  void measure_gaps();
  int column(double x) const;
  int row(double y) const;
  bool covers(double x, double y) const;
  Buckets buckets_around(double x, double y, double half_x, double half_y) const;
  bool all_buckets(const Buckets& b) const;
  template <class Visit>
  bool any_point(const Buckets& buckets, Visit visit) const;

  Path points_ = Path(0, 2);
  std::vector<double> uncertainty_;
  double corner_x_ = 0, corner_y_ = 0, cells_per_metre_ = 1;
  int width_ = 0, height_ = 0, bucket_columns_ = 0, bucket_rows_ = 0;
  std::vector<std::uint8_t> gaps_;       // (height, width): squared gap [cells] to the nearest cell with a point
  std::vector<std::uint32_t> first_;     // of each bucket in sorted_, row by row, and the end
  std::vector<Eigen::Vector2d> sorted_;  // the points, bucket by bucket
};

}  // namespace lfdcore
