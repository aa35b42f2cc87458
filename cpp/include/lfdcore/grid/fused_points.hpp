// Points on the surfaces that a LIDAR hits again and again: each hit improves the mean of the point that it agrees
// with.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace lfdcore {

/// Scans are counted from 1; 0 is never.
using ScanNumber = std::uint32_t;

/// A beam's end: where, the beam's direction (unit length), when.
struct BeamHit {
  double x, y, dx, dy;  // [m]
  double stamp;         // [s]
  ScanNumber scan;
  double walked = 0;  // [m] by which odometry that is wrong may have moved what stands there, since the last scan
};

/// The mean of the hits that agreed with one another.
struct FusedPoint {
  double x, y;              ///< [m]
  double dx, dy;            ///< direction of the last beam that hit it
  double mean_dx, mean_dy;  ///< mean direction of the beams that hit it
  double drift = 0;         ///< low-passed excess of the last ranges over the mean's [m]
  double since;             ///< stamp of the hit that it began with, or last moved with [s]
  double seen;              ///< stamp of the last hit [s]
  ScanNumber scan;          ///< of the last hit
  double mean_scan;         ///< mean of the hits' scans
  std::int32_t hits = 1;    ///< in the mean, at most most_hits
  std::int32_t misses = 0;
  bool young = false;      ///< stands where space had just been seen empty (see RollingMap)
  std::int32_t next = -1;  ///< in its bucket
};

/// Fused points with an index by place. A hit agrees with a point that it lies beside by at most `across`, nearer or
/// farther along the beam by at most 4 standard errors of their difference, and that was last seen from within 41
/// degrees of the same direction, so that the two faces of a board stay two. It goes to the one that it agrees with
/// best, and moves it to the mean of at most the last 100 hits or so, or of fewer where odometry that is wrong makes
/// what stands there walk: of as many as make 3 standard errors and what it walks meanwhile least in sum; one that
/// agrees with none is a new point, unless it lies up to 8 standard errors behind a point of 3 hits or more: it is
/// noise, or that point is about to be dropped. A point whose recent ranges all lie to one side (their low-pass beyond
/// 2 standard deviations) has moved: it goes there, as a mean of 5 hits.
class FusedPoints {
 public:
  static constexpr double across = 0.015;  ///< [m]
  static constexpr std::int32_t most_hits = 100, doubtful_hits = 2;
  static constexpr double bucket = 0.1;  ///< side [m] of a bucket

  struct Fused {
    FusedPoint* point;  ///< null: the hit was no point
    bool fresh;         ///< new there, or moved
    double stood = 0;   ///< [s] how long it had stood before it moved
  };

  /// noise: sd of a range [m]; side: of the square that all points lie in, in buckets, a power of two.
  FusedPoints(double noise, int side);

  Fused fuse(const BeamHit& hit);

  /// Standard error [m] of a mean of so many hits, by how much a range may differ from it: sd sqrt(1 + 1 / hits).
  double innovation(const FusedPoint& point) const { return noise_ * std::sqrt(1 + 1.0 / point.hits); }
  /// Standard error of the point along its beam [m].
  double standard_error(const FusedPoint& point) const { return noise_ / std::sqrt(point.hits); }

  /// True if `is(point)` for a point within `distance` [m] of a place.
  template <class Is>
  bool any_near(double x, double y, double distance, Is is) const {
    bool found = false;
    visit_box(x, y, distance, distance, [&](std::int32_t i) {
      const FusedPoint& point = points_[i];
      found = found || (std::hypot(point.x - x, point.y - y) <= distance && is(point));
    });
    return found;
  }

  /// Calls visit(one, other) for each pair of neighbours on a surface with a gap between them that a beam did not look
  /// into: more than `least` and at most `most` apart [m], both within `reach` of a place, and no third point in the
  /// circle that has them at its ends (Gabriel's graph).
  template <class Visit>
  void visit_gaps(double x, double y, double reach, double least, double most, Visit visit) const {
    std::vector<std::int32_t> around;
    visit_box(x, y, reach, reach, [&](std::int32_t i) {
      const FusedPoint& one = points_[i];
      if (std::hypot(one.x - x, one.y - y) > reach) return;
      around.clear();
      visit_box(one.x, one.y, most, most, [&](std::int32_t k) { around.push_back(k); });
      for (const std::int32_t j : around) {
        const FusedPoint& other = points_[j];
        const double apart = std::hypot(other.x - one.x, other.y - one.y);
        if (j <= i || apart <= least || apart > most || std::hypot(other.x - x, other.y - y) > reach) continue;
        if (std::none_of(around.begin(), around.end(), [&](std::int32_t k) { return between(one, points_[k], other); }))
          visit(one, other);
      }
    });
  }

  /// Forgets the points for which `stale(point)` holds; it may change them, but not move them.
  template <class Stale>
  void drop_if(Stale stale) {
    for (std::size_t i = 0; i < points_.size();)
      if (stale(points_[i]))
        drop(static_cast<std::int32_t>(i));
      else
        ++i;
  }
  void clear();

  const std::vector<FusedPoint>& points() const { return points_; }

 private:
  static std::int64_t bucket_of(double metres) { return static_cast<std::int64_t>(std::floor(metres / bucket)); }
  std::int32_t& first_in_bucket(double x, double y);
  // Sees the two others under more than a right angle.
  static bool between(const FusedPoint& one, const FusedPoint& point, const FusedPoint& other) {
    return (one.x - point.x) * (other.x - point.x) + (one.y - point.y) * (other.y - point.y) < 0;
  }
  // All points in the buckets that the box covers, and maybe some of others.
  template <class Visit>
  void visit_box(double x, double y, double half_x, double half_y, Visit visit) const {
    const std::int64_t right = bucket_of(x + half_x), top = bucket_of(y + half_y);
    for (std::int64_t iy = bucket_of(y - half_y); iy <= top; ++iy)
      for (std::int64_t ix = bucket_of(x - half_x); ix <= right; ++ix)
        for (std::int32_t i = buckets_[(iy & (side_ - 1)) * side_ + (ix & (side_ - 1))]; i >= 0; i = points_[i].next)
          visit(i);
  }
  struct Match {
    std::int32_t index = -1;  // of the point that the hit agrees with best
    bool behind = false;      // it lies behind one
  };
  Match match(const BeamHit& hit) const;
  std::int32_t best_hits(double walked) const;
  void average(FusedPoint& point, const BeamHit& hit);
  bool follow_drift(FusedPoint& point, const BeamHit& hit);
  void link(std::int32_t index);
  void unlink(std::int32_t index);
  void drop(std::int32_t index);

  double noise_;
  int side_;
  std::vector<std::int32_t> buckets_;  // a torus of the first point in each
  std::vector<FusedPoint> points_;
};

}  // namespace lfdcore
