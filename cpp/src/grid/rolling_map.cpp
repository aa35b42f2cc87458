#include "lfdcore/grid/rolling_map.hpp"

#include <bit>
#include <cmath>
#include <string>
#include <utility>

#include "lfdcore/grid/cell_walk.hpp"
#include "lfdcore/grid/scan_mapping.hpp"
#include "pose_check.hpp"

namespace lfdcore {
namespace {

constexpr double resolution = 0.025;  // [m] of a cell
constexpr double smallest_side = 10;  // [m] of the square
constexpr double beam_radius = 0.02;  // [m] a beam this near a point passes through what stood there ...
constexpr double seen_beyond = 0.3;   // [m] ... if it goes on this far
constexpr std::size_t usual_hits = 16384;

std::int64_t cell_of(double metres) {
  const double cells = metres / resolution;
  const auto towards_zero = static_cast<std::int64_t>(cells);
  return towards_zero - (static_cast<double>(towards_zero) > cells ? 1 : 0);
}

}  // namespace

RollingMap::RollingMap(double duration, double radius) : duration_(duration), radius_(radius) {
  require_positive("duration", duration, "s");
  require_between("radius", radius, 0.5, 20, "m");
  const double side = std::max(smallest_side, 2 * radius + 1);
  side_ = static_cast<int>(std::bit_ceil(static_cast<unsigned>(std::ceil(side / resolution))));
  cells_.resize(static_cast<std::size_t>(side_) * side_);
  hits_.reserve(usual_hits);
}

void RollingMap::clear() {
  std::fill(cells_.begin(), cells_.end(), CellState{});
  hits_.clear();
  stamps_.clear();
  first_stamp_ = 0;
  last_scan_ = 0;
}

std::int64_t RollingMap::slot_at(double x, double y) const {
  const std::int64_t ix = cell_of(x), iy = cell_of(y);
  const std::int64_t from_left = ix - corner_ix_, from_bottom = iy - corner_iy_;
  if (from_left < 0 || from_left >= side_ || from_bottom < 0 || from_bottom >= side_) return outside;
  return (iy & (side_ - 1)) * side_ + (ix & (side_ - 1));
}

void RollingMap::insert(double stamp, const LaserScan& scan, const Pose2& T_base_laser, const Pose2& T_odom_base) {
  validate(scan);
  require_finite("stamp", stamp, "s");
  require_pose("T_base_laser", T_base_laser);
  require_pose("T_odom_base", T_odom_base);
  if (!stamps_.empty() && stamp < stamps_.back())
    throw std::invalid_argument("stamp is " + std::to_string(stamp) + " s, must not precede the last scan's, " +
                                std::to_string(stamps_.back()) + " s");
  count_scan(stamp);
  follow(T_odom_base.x, T_odom_base.y);
  const Pose2 T_odom_laser = T_odom_base * T_base_laser;
  read_rays(scan, T_odom_laser.yaw);
  mark_free(T_odom_laser);
  add_hits(T_odom_laser);
  drop_stale_hits(scan, T_odom_laser);
}

void RollingMap::count_scan(double stamp) {
  ++last_scan_;
  while (first_stamp_ < stamps_.size() && stamps_[first_stamp_] < stamp - duration_) ++first_stamp_;
  // Moves the rest to the front now and then, so that the buffer stops growing.
  if (2 * first_stamp_ > stamps_.size()) {
    stamps_.erase(stamps_.begin(), stamps_.begin() + static_cast<std::ptrdiff_t>(first_stamp_));
    first_stamp_ = 0;
  }
  stamps_.push_back(stamp);
}

// Puts the square around the robot and forgets the cells that it leaves.
void RollingMap::follow(double x, double y) {
  const std::int64_t old_x = std::exchange(corner_ix_, cell_of(x) - side_ / 2);
  const std::int64_t old_y = std::exchange(corner_iy_, cell_of(y) - side_ / 2);
  const std::int64_t dx = corner_ix_ - old_x, dy = corner_iy_ - old_y;
  if (dx == 0 && dy == 0) return;
  drop_hits_if([this](const Hit& hit) { return slot_at(hit.x, hit.y) == outside; });
  const auto moved = [this](std::int64_t shift) { return std::clamp<std::int64_t>(shift, -side_, side_); };
  if (dx > 0) forget_free_columns(corner_ix_ + side_ - moved(dx), corner_ix_ + side_);
  if (dx < 0) forget_free_columns(corner_ix_, corner_ix_ - moved(dx));
  if (dy > 0) forget_free_rows(corner_iy_ + side_ - moved(dy), corner_iy_ + side_);
  if (dy < 0) forget_free_rows(corner_iy_, corner_iy_ - moved(dy));
}

void RollingMap::forget_free_columns(std::int64_t from, std::int64_t to) {
  for (int iy = 0; iy < side_; ++iy)
    for (std::int64_t ix = from; ix < to; ++ix) cells_[iy * side_ + (ix & (side_ - 1))].last_free = 0;
}

void RollingMap::forget_free_rows(std::int64_t from, std::int64_t to) {
  for (std::int64_t iy = from; iy < to; ++iy)
    for (int ix = 0; ix < side_; ++ix) cells_[(iy & (side_ - 1)) * side_ + ix].last_free = 0;
}

void RollingMap::read_rays(const LaserScan& scan, double yaw) {
  rays_.resize(scan.ranges.size());
  for (std::size_t i = 0; i < rays_.size(); ++i) {
    const Beam beam = read_beam(scan, i);
    const double angle = yaw + scan.angle(i);
    rays_[i] = {std::cos(angle), std::sin(angle), beam.length, beam.hit};
  }
}

void RollingMap::mark_free(const Pose2& T_odom_laser) {
  const double x = T_odom_laser.x / resolution - static_cast<double>(corner_ix_);
  const double y = T_odom_laser.y / resolution - static_cast<double>(corner_iy_);
  for (const Ray& ray : rays_) {
    if (!(ray.length > 0)) continue;
    walk_cells({x, y, ray.dx, ray.dy}, side_, side_, ray.length / resolution, [this](Cell cell) {
      const std::int64_t ix = (corner_ix_ + cell.ix) & (side_ - 1), iy = (corner_iy_ + cell.iy) & (side_ - 1);
      cells_[iy * side_ + ix].last_free = last_scan_;
    });
  }
}

void RollingMap::add_hits(const Pose2& T_odom_laser) {
  for (const Ray& ray : rays_) {
    if (!ray.hit || ray.length > 2 * farthest) continue;
    const double x = T_odom_laser.x + ray.length * ray.dx, y = T_odom_laser.y + ray.length * ray.dy;
    const std::int64_t slot = slot_at(x, y);
    if (slot == outside) continue;
    CellState& cell = cells_[slot];
    cell.last_free = 0;
    if (cell.hit < 0) {
      cell.hit = static_cast<std::int32_t>(hits_.size());
      hits_.emplace_back();
    }
    hits_[cell.hit] = {x, y, last_scan_, static_cast<std::uint32_t>(slot)};
  }
}

void RollingMap::drop_stale_hits(const LaserScan& scan, const Pose2& T_odom_laser) {
  const ScanNumber oldest = oldest_scan();
  drop_hits_if([&](const Hit& hit) {
    return hit.scan != last_scan_ && (hit.scan < oldest || seen_through(hit, scan, T_odom_laser));
  });
}

// Looks only at the beams whose angle brings them near enough to the point.
bool RollingMap::seen_through(const Hit& hit, const LaserScan& scan, const Pose2& T_odom_laser) const {
  const double dx = hit.x - T_odom_laser.x, dy = hit.y - T_odom_laser.y, distance = std::hypot(dx, dy);
  const double sign = scan.angle_increment > 0 ? 1 : -1, increment = std::abs(scan.angle_increment);
  const double last = increment * static_cast<double>(rays_.size() - 1);
  if (last > 4 * pi) return any_through(hit, T_odom_laser, 0, rays_.size());
  const double spread = distance > beam_radius ? std::asin(beam_radius / distance) + 1e-9 : pi;
  // Angle from beam 0 on, in the direction in which the scan turns, less than a turn.
  const double turned = sign * (std::atan2(dy, dx) - T_odom_laser.yaw - scan.angle_min);
  const double start = turned - 2 * pi * std::floor(turned / (2 * pi));
  for (double angle = start - 2 * pi; angle <= last + spread; angle += 2 * pi) {
    if (angle + spread < 0) continue;
    const double beams = static_cast<double>(rays_.size());
    const auto from = static_cast<std::size_t>(std::clamp(std::ceil((angle - spread) / increment), 0.0, beams));
    const auto to = static_cast<std::size_t>(std::clamp(std::floor((angle + spread) / increment) + 1, 0.0, beams));
    if (any_through(hit, T_odom_laser, from, to)) return true;
  }
  return false;
}

bool RollingMap::any_through(const Hit& hit, const Pose2& T_odom_laser, std::size_t from, std::size_t to) const {
  const double dx = hit.x - T_odom_laser.x, dy = hit.y - T_odom_laser.y;
  for (std::size_t i = from; i < to; ++i) {
    const Ray& ray = rays_[i];
    const double along = dx * ray.dx + dy * ray.dy, beside = dx * ray.dy - dy * ray.dx;
    if (along >= 0 && std::abs(beside) <= beam_radius && along + seen_beyond <= ray.length) return true;
  }
  return false;
}

template <class Stale>
void RollingMap::drop_hits_if(Stale stale) {
  for (std::size_t i = 0; i < hits_.size();) {
    if (!stale(hits_[i])) {
      ++i;
      continue;
    }
    cells_[hits_[i].slot].hit = -1;
    if (i + 1 < hits_.size()) {
      hits_[i] = hits_.back();
      cells_[hits_[i].slot].hit = static_cast<std::int32_t>(i);
    }
    hits_.pop_back();
  }
}

ObstaclePoints RollingMap::obstacles(const Pose2& T_odom_base) const {
  require_pose("T_odom_base", T_odom_base);
  const double c = std::cos(T_odom_base.yaw), s = std::sin(T_odom_base.yaw);
  Path points(static_cast<Eigen::Index>(hits_.size()), 2);
  Eigen::Index count = 0;
  for (const Hit& hit : hits_) {
    const double dx = hit.x - T_odom_base.x, dy = hit.y - T_odom_base.y;
    if (dx * dx + dy * dy <= radius_ * radius_) points.row(count++) << c * dx + s * dy, -s * dx + c * dy;
  }
  points.conservativeResize(count, 2);
  return ObstaclePoints(std::move(points));
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
        const double x = centre.x() + (quarter % 2 == 0 ? -0.5 : 0.5) * resolution;
        const double y = centre.y() + (quarter < 2 ? -0.5 : 0.5) * resolution;
        const std::int64_t slot = slot_at(T_odom_base.x + c * x - s * y, T_odom_base.y + s * x + c * y);
        if (slot != outside && cells_[slot].last_free >= oldest) grid.data(iy, ix) = free_cell;
      }
    }
  }
  for (const Hit& hit : hits_) {
    const double dx = hit.x - T_odom_base.x, dy = hit.y - T_odom_base.y;
    const Cell cell = grid.geometry.cell_at(c * dx + s * dy, -s * dx + c * dy);
    if (grid.geometry.contains(cell)) grid.data(cell.iy, cell.ix) = occupied_cell;
  }
  return grid;
}

}  // namespace lfdcore
