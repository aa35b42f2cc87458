#include "lfdcore/grid/fused_points.hpp"

namespace lfdcore {
namespace {

constexpr std::size_t usual_points = 16384;
constexpr double gate = 4;          // standard errors within which a hit agrees with a point
constexpr double same_side = 0.75;  // cosine between two beams that can hit the same surface
constexpr double drift_gain = 0.3;  // of the low-pass, worth a mean of (2 - 0.3) / 0.3 = 5.7 hits, sd 0.42 of one
constexpr double moved_beyond = 2;  // [sd of a range], 4.8 sd of the low-pass
constexpr std::int32_t moved_hits = 5;

}  // namespace

FusedPoints::FusedPoints(double noise, int side)
    : noise_(noise), side_(side), buckets_(static_cast<std::size_t>(side) * side, -1) {
  points_.reserve(usual_points);
}

void FusedPoints::clear() {
  std::fill(buckets_.begin(), buckets_.end(), -1);
  points_.clear();
}

std::int32_t& FusedPoints::first_in_bucket(double x, double y) {
  return buckets_[(bucket_of(y) & (side_ - 1)) * side_ + (bucket_of(x) & (side_ - 1))];
}

void FusedPoints::link(std::int32_t index) {
  std::int32_t& first = first_in_bucket(points_[index].x, points_[index].y);
  points_[index].next = first;
  first = index;
}

void FusedPoints::unlink(std::int32_t index) {
  std::int32_t* link = &first_in_bucket(points_[index].x, points_[index].y);
  while (*link != index) link = &points_[*link].next;
  *link = points_[index].next;
}

void FusedPoints::drop(std::int32_t index) {
  unlink(index);
  const auto last = static_cast<std::int32_t>(points_.size()) - 1;
  if (index != last) {
    unlink(last);
    points_[index] = points_[last];
    link(index);
  }
  points_.pop_back();
}

FusedPoints::Match FusedPoints::match(const BeamHit& hit) const {
  const double farthest = gate * noise_ * std::sqrt(2.0);
  const double back_x = farthest * hit.dx / 2, back_y = farthest * hit.dy / 2;
  Match match;
  double least = 1;
  visit_box(hit.x - back_x, hit.y - back_y, 3 * std::abs(back_x) + across, 3 * std::abs(back_y) + across,
            [&](std::int32_t i) {
              const FusedPoint& point = points_[i];
              const double x = hit.x - point.x, y = hit.y - point.y;
              const double beside = (x * hit.dy - y * hit.dx) / across;
              if (std::abs(beside) > 1 || point.dx * hit.dx + point.dy * hit.dy < same_side) return;
              const double along = (x * hit.dx + y * hit.dy) / (gate * innovation(point));
              match.behind = match.behind || (along > 1 && along <= 2 && point.hits > doubtful_hits);
              const double distance = (along * along + beside * beside) / 2;
              if (std::abs(along) > 1 || distance > least) return;
              least = distance;
              match.index = i;
            });
  return match;
}

FusedPoints::Fused FusedPoints::fuse(const BeamHit& hit) {
  auto [index, behind] = match(hit);
  bool fresh = index < 0;
  double stood = 0;
  if (fresh && behind) return {nullptr, false};
  if (fresh) {
    index = static_cast<std::int32_t>(points_.size());
    points_.push_back({hit.x, hit.y, hit.dx, hit.dy, hit.dx, hit.dy, 0, hit.stamp, hit.stamp, hit.scan,
                       static_cast<double>(hit.scan)});
  } else {
    unlink(index);
    average(points_[index], hit);
    stood = hit.stamp - points_[index].since;
    fresh = follow_drift(points_[index], hit);
  }
  link(index);
  return {&points_[index], fresh, stood};
}

// Where 3 noise / sqrt(n) + walked n is least.
std::int32_t FusedPoints::best_hits(double walked) const {
  const double ratio = 1.5 * noise_ / std::max(walked, 1e-9);
  return std::clamp(static_cast<std::int32_t>(std::min(std::cbrt(ratio * ratio), 1e3)), doubtful_hits + 1, most_hits);
}

void FusedPoints::average(FusedPoint& point, const BeamHit& hit) {
  const double x = hit.x - point.x, y = hit.y - point.y;
  point.drift += drift_gain * (x * hit.dx + y * hit.dy - point.drift);
  point.hits = std::min(point.hits + 1, best_hits(hit.walked));
  point.x += x / point.hits;
  point.y += y / point.hits;
  point.mean_dx += (hit.dx - point.mean_dx) / point.hits;
  point.mean_dy += (hit.dy - point.mean_dy) / point.hits;
  point.mean_scan += (hit.scan - point.mean_scan) / point.hits;
  point.dx = hit.dx;
  point.dy = hit.dy;
  point.seen = hit.stamp;
  point.scan = hit.scan;
  point.misses = 0;
}

bool FusedPoints::follow_drift(FusedPoint& point, const BeamHit& hit) {
  if (point.hits <= moved_hits || std::abs(point.drift) <= moved_beyond * noise_) return false;
  point.x += point.drift * hit.dx;
  point.y += point.drift * hit.dy;
  point.drift = 0;
  point.hits = moved_hits;
  point.since = hit.stamp;
  point.mean_scan = hit.scan;
  return true;
}

}  // namespace lfdcore
