#include "lfdcore/grid/rolling_map.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "lfdcore/grid/frontier.hpp"
#include "lfdcore/grid/scan_mapping.hpp"
#include "pose_check.hpp"

namespace lfdcore {
namespace {

constexpr double smallest_side = 10;  // [m] of the square

// A beam passes through what stood at a point if it goes on behind it by so many standard errors of the difference, and
// - it is this near, and goes on by so many times its distance from the point more (walls are seen at 3.8 degrees), or
// - so does one on the point's other side, with no more than this gap between the two.
constexpr double passing_errors = 3;
constexpr double beam_radius = 0.004;  // [m] less than the hits of one point lie apart
constexpr double passing_slope = 15;
constexpr double passing_gap = 0.03;        // [m]
constexpr double beside_end = 0.25;         // [m] so near, the next beam shows that a surface ends at the point
constexpr std::int32_t misses_to_drop = 3;  // scans; what may be noise goes at the first
constexpr double farthest_noise = 5;        // [sd of a range] from a surer point

constexpr double recent = 3;           // [s] how long before a person stepped in the space was seen empty
constexpr double settling = 3;         // [s] of hits, after which it is as good as furniture
constexpr double fading = 3;           // [s] after which it is forgotten, unless it has settled
constexpr double kin_distance = 0.06;  // [m] a point is of the same thing as another so near ...
constexpr double settled_age = 1;      // [s] ... not young, if that has stood there for so long, or as long as ...
constexpr double slipping = 2;         // ... so many times the odometry's error lets a thing stand ...
constexpr double kin_age = 0.5;        // [s] ... else young, if that is and was hit so recently, and this was empty

constexpr double sure_errors = 3;       // [sd of a range] before its end, a beam has surely passed
constexpr double uncertain_errors = 3;  // standard errors of a point's uncertainty
constexpr double round_error = 0.01;    // [m] of it is given as an uncertainty to all sides, more of it along the beams
constexpr double least_shift = 0.005;   // [m] nearer places are left out
constexpr std::size_t most_places = 10;

constexpr double filled_within = 2;      // [m] farther away, no chair can be before the next scan
constexpr double filled_spacing = 0.03;  // [m] no corner of a body gets between points with half of it around them
constexpr double widest_gap = 0.25;      // [m] no body gets through it

constexpr double coarse = 2 * SeenCells::resolution;  // [m] cells of the unseen space ...
constexpr int crack = 5;                              // [cells] ... narrower gaps in what was seen do not count ...
constexpr double under_body = 0.036;                  // [m] ... a cell with its centre this near the body is under it
constexpr double near_body = 0.1;                     // [m] at most ahead of or behind the body: its quarters count
constexpr double quarter_half = 0.018;  // [m] half the diagonal of a quarter: so near, it is under the body
constexpr double unsure_seen = 0.1;     // [m] by which the odometry may be wrong before what was seen no longer counts

double distance_outside(const Footprint& body, double x, double y) {
  const double beyond = std::max({x - body.front, -body.rear - x, 0.0});
  return std::hypot(beyond, std::max(std::abs(y) - body.half_width, 0.0));
}

}  // namespace

void validate(const RollingMapConfig& config) {
  require_positive("duration", config.duration, "s");
  require_between("radius", config.radius, 0.5, 20, "m");
  require_between("range_noise", config.range_noise, 0.001, 0.2, "m");
  require_between("odometry_error", config.odometry_error, 0, 0.5, "(share)");
  if (config.own_body) require_bounded(*config.own_body);
}

RollingMap::RollingMap(const RollingMapConfig& config)
    : config_((validate(config), config)),
      cells_(std::max(smallest_side, 2 * config.radius + 1)),
      points_(config.range_noise, cells_.side() / 4) {}

void RollingMap::clear() {
  cells_.clear();
  points_.clear();
  taken_.clear();
  first_taken_ = 0;
  last_scan_ = 0;
  recent_scan_ = sure_scan_ = 1;
}

void RollingMap::insert(double stamp, const LaserScan& scan, const Pose2& T_base_laser, const Pose2& T_odom_base) {
  validate(scan);
  require_finite("stamp", stamp, "s");
  require_pose("T_base_laser", T_base_laser);
  require_pose("T_odom_base", T_odom_base);
  if (!taken_.empty() && stamp < taken_.back().stamp)
    throw std::invalid_argument("stamp is " + std::to_string(stamp) + " s, must not precede the last scan's, " +
                                std::to_string(taken_.back().stamp) + " s");
  count_scan(stamp, T_odom_base);
  if (cells_.follow(T_odom_base.x, T_odom_base.y))
    points_.drop_if([this](const FusedPoint& point) { return cells_.at(point.x, point.y) == nullptr; });
  const Pose2 T_odom_laser = T_odom_base * T_base_laser;
  read_rays(scan, T_base_laser, T_odom_laser.yaw);
  add_hits(T_odom_laser);
  mark_free(T_odom_laser);
  if (config_.own_body) cells_.cover(T_odom_base, *config_.own_body, last_scan_);
  drop_stale(scan, T_odom_laser);
}

// The odometry's way goes on from the last scan's to here; a turn happens halfway.
RollingMap::Taken RollingMap::at(double stamp, const Pose2& T_odom_base) const {
  Taken now{stamp, T_odom_base.x, T_odom_base.y};
  if (taken_.empty()) return now;
  const Taken& last = taken_.back();
  const double turn = wrap_angle(T_odom_base.yaw - last_yaw_);
  now.turn = last.turn + turn;
  now.turn_x = last.turn_x + turn * (last.x + now.x) / 2;
  now.turn_y = last.turn_y + turn * (last.y + now.y) / 2;
  return now;
}

void RollingMap::count_scan(double stamp, const Pose2& T_odom_base) {
  const Taken now = at(stamp, T_odom_base);
  last_yaw_ = T_odom_base.yaw;
  forget_old_stamps(stamp);
  taken_.push_back(now);
  ++last_scan_;
  recent_scan_ = std::max(recent_scan_, oldest_scan());
  while (taken(recent_scan_).stamp < stamp - recent) ++recent_scan_;
  sure_scan_ = std::max(sure_scan_, oldest_scan());
  while (sure_scan_ < last_scan_ && odometry_error(taken(sure_scan_)) > unsure_seen) ++sure_scan_;
}

// By how much [m] the odometry may have put what the robot can sweep over in a wrong place, since a scan.
double RollingMap::odometry_error(const Taken& then) const {
  const Taken& now = taken_.back();
  const double lever = config_.own_body ? config_.own_body->outer_radius() : 1.0;
  return config_.odometry_error * (std::hypot(now.x - then.x, now.y - then.y) + std::abs(now.turn - then.turn) * lever);
}

// Moves the rest to the front now and then, so that the buffer stops growing.
void RollingMap::forget_old_stamps(double stamp) {
  while (first_taken_ < taken_.size() && taken_[first_taken_].stamp < stamp - config_.duration) ++first_taken_;
  if (2 * first_taken_ <= taken_.size()) return;
  taken_.erase(taken_.begin(), taken_.begin() + static_cast<std::ptrdiff_t>(first_taken_));
  first_taken_ = 0;
}

void RollingMap::read_rays(const LaserScan& scan, const Pose2& T_base_laser, double yaw) {
  rays_.resize(scan.ranges.size());
  for (std::size_t i = 0; i < rays_.size(); ++i) {
    const Beam beam = read_beam(scan, i);
    const double angle = yaw + scan.angle(i);
    rays_[i] = {std::cos(angle), std::sin(angle), beam.length, beam.hit};
    if (beam.hit && config_.own_body && own(T_base_laser, scan.angle(i), beam.length)) rays_[i] = {1, 0, 0, false};
  }
}

bool RollingMap::own(const Pose2& T_base_laser, double angle, double length) const {
  const Eigen::Vector2d end = T_base_laser * Eigen::Vector2d(length * std::cos(angle), length * std::sin(angle));
  return distance_outside(config_.own_body->grown(-own_depth), end.x(), end.y()) == 0;
}

void RollingMap::add_hits(const Pose2& T_odom_laser) {
  const double stamp = taken_.back().stamp;
  for (const Ray& ray : rays_) {
    if (!ray.hit || ray.length > 2 * farthest) continue;
    const double x = T_odom_laser.x + ray.length * ray.dx, y = T_odom_laser.y + ray.length * ray.dy;
    if (cells_.at(x, y) == nullptr) continue;
    const double walked = walked_since_last_scan(ray.length);
    const auto [point, fresh, stood] = points_.fuse({x, y, ray.dx, ray.dy, stamp, last_scan_, walked});
    if (point == nullptr) continue;
    if (fresh)
      point->young = point->young || (stood < settled_for(walked) && is_young(*point, walked));
    else if (point->young && stamp - point->since >= settling)
      point->young = false;
  }
}

// By how much [m] odometry that is wrong may have moved what stands at this distance from the robot.
double RollingMap::walked_since_last_scan(double distance) const {
  if (taken_.size() < first_taken_ + 2) return 0;
  const Taken &now = taken_.back(), &before = taken_[taken_.size() - 2];
  return config_.odometry_error *
         (std::hypot(now.x - before.x, now.y - before.y) + std::abs(now.turn - before.turn) * distance);
}

// How long [s] a point must have stood to be no person's: 1 s, or less where furniture walks so far between two scans.
double RollingMap::settled_for(double walked) const {
  if (walked <= 0) return settled_age;
  const double passed = taken_.back().stamp - taken_[taken_.size() - 2].stamp;
  return std::min(settled_age, passed * std::max(FusedPoints::across / (slipping * walked) - 1, 0.0));
}

bool RollingMap::is_young(const FusedPoint& point, double walked) const {
  const double age = settled_for(walked);
  const auto near = [&](auto is) { return points_.any_near(point.x, point.y, kin_distance, is); };
  const auto stands = [&](const FusedPoint& p) {
    return p.since < point.since && (p.misses == 0 || point.seen - p.seen <= kin_age);
  };
  if (near([&](const FusedPoint& p) { return !p.young && stands(p) && p.seen - p.since >= age; })) return false;
  if (cells_.clear_around(point.x, point.y, recent_scan_)) return true;
  const SeenCells::State* here = cells_.at(point.x, point.y);
  return here != nullptr && here->last_clear >= recent_scan_ &&
         near([&](const FusedPoint& p) { return p.young && point.seen - p.seen <= kin_age; });
}

void RollingMap::mark_free(const Pose2& T_odom_laser) {
  const double unsure = sure_errors * config_.range_noise;
  for (const Ray& ray : rays_) {
    if (!(ray.length > 0)) continue;
    cells_.cross(T_odom_laser.x, T_odom_laser.y, ray.dx, ray.dy, ray.length, ray.length - (ray.hit ? unsure : 0),
                 last_scan_);
  }
  for (const Ray& ray : rays_)
    if (ray.hit && ray.length <= 2 * farthest)
      cells_.hit(T_odom_laser.x + ray.length * ray.dx, T_odom_laser.y + ray.length * ray.dy);
}

// All are judged before any is dropped: what is near a point does not depend on their order.
void RollingMap::drop_stale(const LaserScan& scan, const Pose2& T_odom_laser) {
  constexpr std::int32_t gone = -1;
  const ScanNumber oldest = oldest_scan();
  const double now = taken_.back().stamp;
  const auto is_stale = [&](FusedPoint& point) {
    if (point.scan == last_scan_) return false;
    if (point.scan < oldest || (point.young && now - point.seen > fading)) return true;
    if (!is_gone(point, scan, T_odom_laser)) return false;
    return is_noise(point) || ++point.misses >= misses_to_drop;
  };
  points_.drop_if([&](FusedPoint& point) {
    if (is_stale(point)) point.misses = gone;
    return false;
  });
  points_.drop_if([](const FusedPoint& point) { return point.misses == gone; });
}

// One or two hits, and a surer point near.
bool RollingMap::is_noise(const FusedPoint& point) const {
  const auto sure = [](const FusedPoint& other) { return other.hits > FusedPoints::doubtful_hits; };
  return !sure(point) && points_.any_near(point.x, point.y, farthest_noise * config_.range_noise, sure);
}

// Beams go on behind it. Where it may lie elsewhere by now, because odometry was wrong, it was hit there, or they go on
// behind all those places too.
bool RollingMap::is_gone(const FusedPoint& point, const LaserScan& scan, const Pose2& T_odom_laser) {
  if (!seen_through(point, scan, T_odom_laser)) return false;
  places_.assign(1, {0, 0});
  if (config_.odometry_error > 0) add_odometry_errors(point, taken_.back(), places_);
  double farthest_place = 0;
  for (const auto& [x, y] : places_) farthest_place = std::max(farthest_place, std::hypot(x, y));
  if (farthest_place <= FusedPoints::across) return true;
  const auto just_hit = [&](const FusedPoint& p) { return p.scan == last_scan_; };
  if (points_.any_near(point.x, point.y, farthest_place + FusedPoints::across, just_hit)) return true;
  return std::all_of(places_.begin(), places_.end(), [&](const Shift& shift) {
    FusedPoint there = point;
    there.x += shift.x;
    there.y += shift.y;
    return seen_through(there, scan, T_odom_laser);
  });
}

// Looks only at the beams whose angle brings them near enough to the point.
bool RollingMap::seen_through(const FusedPoint& point, const LaserScan& scan, const Pose2& T_odom_laser) const {
  if (rays_.empty()) return false;
  const double dx = point.x - T_odom_laser.x, dy = point.y - T_odom_laser.y, distance = std::hypot(dx, dy);
  const double sign = scan.angle_increment > 0 ? 1 : -1, increment = std::abs(scan.angle_increment);
  const double last = increment * static_cast<double>(rays_.size() - 1);
  Passing passing{dx, dy, passing_errors * points_.innovation(point)};
  if (last > 4 * pi) return any_through(passing, 0, rays_.size());
  const double spread = distance > passing_gap ? std::asin(passing_gap / distance) + 1e-9 : pi;
  // Angle from beam 0 on, in the direction in which the scan turns, less than a turn.
  const double turned = sign * (std::atan2(dy, dx) - T_odom_laser.yaw - scan.angle_min);
  const double start = turned - 2 * pi * std::floor(turned / (2 * pi));
  for (double angle = start - 2 * pi; angle <= last + spread; angle += 2 * pi) {
    if (angle + spread < 0) continue;
    const double beams = static_cast<double>(rays_.size());
    const auto from = static_cast<std::size_t>(std::clamp(std::ceil((angle - spread) / increment), 0.0, beams));
    const auto to = static_cast<std::size_t>(std::clamp(std::floor((angle + spread) / increment) + 1, 0.0, beams));
    if (any_through(passing, from, to)) return true;
  }
  return false;
}

// Whether the beam on the point's other side than beam i hit something beside the point: then i passes the end of a
// surface.
bool RollingMap::ends_at(const Passing& passing, std::size_t i, double left) const {
  const auto ends = [&](const Ray& ray) {
    const double along = passing.dx * ray.dx + passing.dy * ray.dy, its = passing.dx * ray.dy - passing.dy * ray.dx;
    const double x = ray.length * ray.dx - passing.dx, y = ray.length * ray.dy - passing.dy;
    return ray.hit && its * left < 0 && ray.length <= along + passing.noise && std::hypot(x, y) <= beside_end;
  };
  return (i > 0 && ends(rays_[i - 1])) || (i + 1 < rays_.size() && ends(rays_[i + 1]));
}

bool RollingMap::any_through(Passing& passing, std::size_t from, std::size_t to) const {
  for (std::size_t i = from; i < to; ++i) {
    const Ray& ray = rays_[i];
    const double along = passing.dx * ray.dx + passing.dy * ray.dy, left = passing.dx * ray.dy - passing.dy * ray.dx;
    const double beyond = ray.length - along - passing.noise, beside = std::abs(left);
    if (along < 0 || beyond <= 0) continue;
    if (beside <= beam_radius && beyond > passing_slope * beside && !ends_at(passing, i, left)) return true;
    double& nearest = left > 0 ? passing.left : passing.right;
    nearest = std::min(nearest, beside);
    if (passing.left + passing.right <= passing_gap) return true;
  }
  return false;
}

ObstaclePoints RollingMap::obstacles(const Pose2& T_odom_base) const {
  require_pose("T_odom_base", T_odom_base);
  const double c = std::cos(T_odom_base.yaw), s = std::sin(T_odom_base.yaw);
  const Taken now = at(0, T_odom_base);
  std::vector<FusedPoint> near;
  for (const FusedPoint& point : points_.points())
    if (std::hypot(point.x - T_odom_base.x, point.y - T_odom_base.y) <= config_.radius) near.push_back(point);
  fill_gaps(T_odom_base, near);
  std::vector<Shift> places;
  std::vector<double> uncertainty;
  Path points(static_cast<Eigen::Index>(near.size() * most_places), 2);
  for (const FusedPoint& point : near) {
    const double dx = point.x - T_odom_base.x, dy = point.y - T_odom_base.y;
    const double error = uncertain_errors * points_.standard_error(point);
    find_places(point, error, now, places);
    for (const auto& [x, y] : places) {
      points.row(static_cast<Eigen::Index>(uncertainty.size())) << c * (dx + x) + s * (dy + y),
          -s * (dx + x) + c * (dy + y);
      uncertainty.push_back(std::min(error, round_error));
    }
  }
  points.conservativeResize(static_cast<Eigen::Index>(uncertainty.size()), 2);
  return ObstaclePoints(std::move(points), std::move(uncertainty));
}

// A wall that is seen at a grazing angle has a point every 10 cm; a corner of the chair would swing in between.
void RollingMap::fill_gaps(const Pose2& T_odom_base, std::vector<FusedPoint>& points) const {
  const double reach = std::min(filled_within, config_.radius);
  const auto fill = [&](const FusedPoint& one, const FusedPoint& other) {
    const double dx = other.x - one.x, dy = other.y - one.y;
    const int parts = static_cast<int>(std::ceil(std::hypot(dx, dy) / filled_spacing));
    FusedPoint point = one.hits <= other.hits ? one : other;
    for (int k = 1; k < parts; ++k) {
      point.x = one.x + dx * k / parts;
      point.y = one.y + dy * k / parts;
      points.push_back(point);
    }
  };
  points_.visit_gaps(T_odom_base.x, T_odom_base.y, reach, filled_spacing, widest_gap, fill);
}

ObstaclePoints RollingMap::walkers(const Pose2& T_odom_base) const {
  require_pose("T_odom_base", T_odom_base);
  const Pose2 T_base_odom = T_odom_base.inverse();
  std::vector<double> points, uncertainty;
  for (const FusedPoint& point : points_.points()) {
    if (!point.young || point.scan != last_scan_) continue;
    const Eigen::Vector2d place = T_base_odom * Eigen::Vector2d(point.x, point.y);
    points.insert(points.end(), {place.x(), place.y()});
    uncertainty.push_back(uncertain_errors * points_.standard_error(point));
  }
  return ObstaclePoints(Eigen::Map<const Path>(points.data(), static_cast<Eigen::Index>(points.size() / 2), 2),
                        std::move(uncertainty));
}

// Where a point may be, as shifts from its mean: there, or nearer along its beams; either moved by the odometry's
// error.
void RollingMap::find_places(const FusedPoint& point, double error, const Taken& now,
                             std::vector<Shift>& places) const {
  places.assign(1, {0, 0});
  const double nearer = error - round_error, length = std::hypot(point.mean_dx, point.mean_dy);
  if (nearer >= least_shift) places.push_back({-nearer * point.mean_dx / length, -nearer * point.mean_dy / length});
  if (config_.odometry_error > 0) add_odometry_errors(point, now, places);
}

// To first order: too long a way moves everything along it; a turn that was wrong by an angle turns the point by it
// about the place of the turn, which adds up to angle x (point - mean place of turning).
void RollingMap::add_odometry_errors(const FusedPoint& point, const Taken& now, std::vector<Shift>& places) const {
  const Taken& then = taken(std::max(static_cast<ScanNumber>(point.mean_scan), oldest_scan()));
  const double turn = now.turn - then.turn, share = config_.odometry_error;
  const Shift way{share * (now.x - then.x), share * (now.y - then.y)};
  const Shift arc{-share * (turn * point.y - (now.turn_y - then.turn_y)),
                  share * (turn * point.x - (now.turn_x - then.turn_x))};
  const std::size_t standing = places.size();
  const auto add = [&](double x, double y) {
    if (std::hypot(x, y) < least_shift) return;
    for (std::size_t i = 0; i < standing; ++i) {
      const Shift from = places[i];
      places.push_back({from.x + x, from.y + y});
      places.push_back({from.x - x, from.y - y});
    }
  };
  add(way.x + arc.x, way.y + arc.y);
  if (std::min(std::hypot(way.x, way.y), std::hypot(arc.x, arc.y)) >= least_shift) add(way.x - arc.x, way.y - arc.y);
}

ObstaclePoints RollingMap::unseen(const Pose2& T_odom_base, const Footprint& body, double reach) const {
  require_pose("T_odom_base", T_odom_base);
  require_bounded(body);
  require_between("reach", reach, 0, 20, "m");
  const double half = body.outer_radius() + reach + (crack + 1) * coarse;
  const double corner_x = coarse * std::floor((T_odom_base.x - half) / coarse);
  const double corner_y = coarse * std::floor((T_odom_base.y - half) / coarse);
  const auto side = static_cast<Eigen::Index>(std::ceil(2 * half / coarse)) + 1;
  const Mask hit = with_points(side, corner_x, corner_y);
  const Mask unknown = unknown_around(T_odom_base, body, side, corner_x, corner_y) && !hit;
  // Behind a face, what is narrow is no gap between beams but the inside of a thing.
  const Mask wide = open_mask(unknown, crack) || (unknown && grown_mask(hit, crack));
  const Mask edge = edge_of(wide), about = grown_mask(wide, 1);
  const Pose2 T_base_odom = T_odom_base.inverse();
  std::vector<double> points, uncertainty;
  for (Eigen::Index iy = 0; iy < side; ++iy)
    for (Eigen::Index ix = 0; ix < side; ++ix) {
      if (!about(iy, ix)) continue;
      const Eigen::Vector2d centre(corner_x + (static_cast<double>(ix) + 0.5) * coarse,
                                   corner_y + (static_cast<double>(iy) + 0.5) * coarse);
      const Eigen::Vector2d place = T_base_odom * centre;
      const double distance = distance_outside(body, place.x(), place.y());
      const bool near = (place.x() < -body.rear || place.x() > body.front) && distance <= near_body;
      if (near)
        add_unseen_quarters(centre, T_base_odom, body, points);
      else if (edge(iy, ix) && distance <= reach)
        points.insert(points.end(), {place.x(), place.y()});
      uncertainty.resize(points.size() / 2, near ? quarter_half : 0);
    }
  return ObstaclePoints(Eigen::Map<const Path>(points.data(), static_cast<Eigen::Index>(points.size() / 2), 2),
                        std::move(uncertainty));
}

// So near, half a cell matters: it is about what a creeping chair needs to stop in.
void RollingMap::add_unseen_quarters(const Eigen::Vector2d& centre, const Pose2& T_base_odom, const Footprint& body,
                                     std::vector<double>& points) const {
  for (const double dy : {-coarse / 4, coarse / 4})
    for (const double dx : {-coarse / 4, coarse / 4}) {
      if (SeenCells::is_seen(cells_.at(centre.x() + dx, centre.y() + dy), sure_scan_)) continue;
      const Eigen::Vector2d place = T_base_odom * (centre + Eigen::Vector2d(dx, dy));
      if (distance_outside(body, place.x(), place.y()) > quarter_half)
        points.insert(points.end(), {place.x(), place.y()});
    }
}

Mask RollingMap::unknown_around(const Pose2& T_odom_base, const Footprint& body, Eigen::Index side, double corner_x,
                                double corner_y) const {
  const Pose2 T_base_odom = T_odom_base.inverse();
  Mask unknown = cells_.unseen_blocks(corner_x, corner_y, side, sure_scan_);
  for (Eigen::Index iy = 0; iy < side; ++iy)
    for (Eigen::Index ix = 0; ix < side; ++ix) {
      if (!unknown(iy, ix)) continue;
      const Eigen::Vector2d centre(corner_x + (static_cast<double>(ix) + 0.5) * coarse,
                                   corner_y + (static_cast<double>(iy) + 0.5) * coarse);
      const Eigen::Vector2d place = T_base_odom * centre;
      unknown(iy, ix) = distance_outside(body, place.x(), place.y()) > under_body;
    }
  return unknown;
}

Mask RollingMap::with_points(Eigen::Index side, double corner_x, double corner_y) const {
  Mask mask = Mask::Constant(side, side, false);
  for (const FusedPoint& point : points_.points()) {
    const auto ix = static_cast<Eigen::Index>(std::floor((point.x - corner_x) / coarse));
    const auto iy = static_cast<Eigen::Index>(std::floor((point.y - corner_y) / coarse));
    if (ix >= 0 && iy >= 0 && ix < side && iy < side) mask(iy, ix) = true;
  }
  return mask;
}

OccupancyGrid RollingMap::local_grid(const Pose2& T_odom_base) const {
  require_pose("T_odom_base", T_odom_base);
  OccupancyGrid grid(local_window(), unknown_cell);
  if (last_scan_ == 0) return grid;
  const ScanNumber oldest = oldest_scan();
  const double c = std::cos(T_odom_base.yaw), s = std::sin(T_odom_base.yaw);
  for (int iy = 0; iy < grid.geometry.height; ++iy) {
    for (int ix = 0; ix < grid.geometry.width; ++ix) {
      const Eigen::Vector2d centre = grid.geometry.centre({ix, iy});
      for (int quarter = 0; quarter < 4; ++quarter) {
        const double x = centre.x() + (quarter % 2 == 0 ? -0.5 : 0.5) * SeenCells::resolution;
        const double y = centre.y() + (quarter < 2 ? -0.5 : 0.5) * SeenCells::resolution;
        const SeenCells::State* cell = cells_.at(T_odom_base.x + c * x - s * y, T_odom_base.y + s * x + c * y);
        if (cell != nullptr && cell->last_free >= oldest) grid.data(iy, ix) = free_cell;
      }
    }
  }
  for (const FusedPoint& point : points_.points()) {
    const double dx = point.x - T_odom_base.x, dy = point.y - T_odom_base.y;
    const Cell cell = grid.geometry.cell_at(c * dx + s * dy, -s * dx + c * dy);
    if (grid.geometry.contains(cell)) grid.data(cell.iy, cell.ix) = occupied_cell;
  }
  return grid;
}

}  // namespace lfdcore
