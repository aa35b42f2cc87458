#include "lfdcore/grid/ray_casting.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "../vectorised.hpp"
#include "lfdcore/error.hpp"
#include "pose_check.hpp"

LFDCORE_VECTOR_MATH(double sin(double));
LFDCORE_VECTOR_MATH(double cos(double));

namespace lfdcore {
namespace {

constexpr int longest_side = 255;
constexpr double smallest_component = 1e-30;  // of a direction: taken as 0, since 1e30 cells are beyond any map

// Rays from one point that leap in step: arrays, so that one instruction serves several rays.
constexpr int lanes = 16;
struct Bundle {
  double x, y;                            // where all start [cells]
  double dx[lanes], dy[lanes];            // unit directions
  double per_x[lanes], per_y[lanes];      // their inverses
  double t[lanes], end[lanes];            // travelled so far and at most [cells]
  std::int32_t ix[lanes], iy[lanes];      // cell reached
  std::int32_t left[lanes], down[lanes];  // 1 if the ray heads to smaller x, y
  std::int32_t going[lanes];              // 0 once decided
  double range[lanes];                    // [cells]
};

// Two loops, because the compiler would fuse sine and cosine of one angle into a scalar call.
LFDCORE_CLONES void sines(const double* angles, double* out) {
  for (int i = 0; i < lanes; ++i) out[i] = sin(angles[i]);
}
LFDCORE_CLONES void cosines(const double* angles, double* out) {
  for (int i = 0; i < lanes; ++i) out[i] = cos(angles[i]);
}

// The loops below are written without branches, each value loaded and stored unconditionally, to be vectorised.

double inverse(double component) {
  return 1 / (std::abs(component) < smallest_component ? smallest_component : component);
}

template <class T>
T between(T value, T low, T high) {
  const T raised = value < low ? low : value;
  return raised > high ? high : raised;
}

// Puts every ray where it enters the map.
LFDCORE_CLONES void enter(Bundle& b, int width, int height, double reach) {
  const double x = b.x, y = b.y;
  for (int i = 0; i < lanes; ++i) {
    const double dx = b.dx[i], dy = b.dy[i], per_x = inverse(dx), per_y = inverse(dy);
    const double low_x = -x * per_x, high_x = (width - x) * per_x, low_y = -y * per_y, high_y = (height - y) * per_y;
    const double from_x = low_x < high_x ? low_x : high_x, to_x = low_x < high_x ? high_x : low_x;
    const double from_y = low_y < high_y ? low_y : high_y, to_y = low_y < high_y ? high_y : low_y;
    const double from_both = from_x > from_y ? from_x : from_y, to_both = to_x < to_y ? to_x : to_y;
    const double from = from_both > 0 ? from_both : 0, to = to_both < reach ? to_both : reach;
    const std::int32_t meets = from <= to;
    const double t = meets ? from : 0;
    b.per_x[i] = per_x;
    b.per_y[i] = per_y;
    b.left[i] = per_x < 0;
    b.down[i] = per_y < 0;
    b.t[i] = t;
    b.end[i] = to;
    b.going[i] = meets;
    b.ix[i] = static_cast<std::int32_t>(between(x + t * dx, 0.0, width - 1.0));
    b.iy[i] = static_cast<std::int32_t>(between(y + t * dy, 0.0, height - 1.0));
    b.range[i] = std::numeric_limits<double>::infinity();
  }
}

// Lets every ray leap to the far edge of its cell's empty square. Returns whether any goes on.
LFDCORE_CLONES std::int32_t leap(Bundle& __restrict b, const std::uint32_t* __restrict sides, std::int32_t width,
                                 std::int32_t height) {
  const double x = b.x, y = b.y;
  std::int32_t any = 0;
  for (int i = 0; i < lanes; ++i) {
    const std::int32_t ix = b.ix[i], iy = b.iy[i], left = b.left[i], down = b.down[i], going = b.going[i];
    const double dx = b.dx[i], dy = b.dy[i], per_x = b.per_x[i], per_y = b.per_y[i];
    const double before = b.t[i], end = b.end[i], range = b.range[i];
    const auto side = static_cast<std::int32_t>((sides[iy * width + ix] >> (8 * (left + 2 * down))) & 255u);
    // The square's last cells, and the edges beyond them.
    const std::int32_t last_x = ix + (side - 1) * (1 - 2 * left), edge_x = last_x + 1 - left;
    const std::int32_t last_y = iy + (side - 1) * (1 - 2 * down), edge_y = last_y + 1 - down;
    const double t_x = (edge_x - x) * per_x, t_y = (edge_y - y) * per_y;
    const std::int32_t across = t_x < t_y;
    const double t = t_x < t_y ? t_x : t_y;
    // Rounding must not carry a ray out of the square sideways. (Of a ray already decided this may be any number.)
    const auto at_x = static_cast<std::int32_t>(x + t * dx), at_y = static_cast<std::int32_t>(y + t * dy);
    const std::int32_t beside_x = between(at_x, left ? last_x : ix, left ? ix : last_x);
    const std::int32_t beside_y = between(at_y, down ? last_y : iy, down ? iy : last_y);
    const std::int32_t next_x = across ? last_x + 1 - 2 * left : beside_x;
    const std::int32_t next_y = across ? beside_y : last_y + 1 - 2 * down;
    const std::int32_t inside = (next_x >= 0) & (next_x < width) & (next_y >= 0) & (next_y < height);
    const std::int32_t goes_on = going & (side != 0) & (t <= end) & inside;
    b.range[i] = (going & (side == 0)) ? before : range;
    b.ix[i] = goes_on ? next_x : ix;
    b.iy[i] = goes_on ? next_y : iy;
    b.t[i] = goes_on ? t : before;
    b.going[i] = goes_on;
    any |= goes_on;
  }
  return any;
}

// Side of the largest square without an occupied cell that extends from each cell towards (step_x, step_y), 0 in
// occupied cells, shifted into its byte. Nothing is occupied beyond the map.
void add_free_sides(const OccupancyGrid& grid, int step_x, int step_y, int shift, std::vector<std::uint32_t>& sides) {
  const int width = grid.geometry.width, height = grid.geometry.height;
  std::vector<int> next_row(width, longest_side);
  for (int j = 0; j < height; ++j) {
    const int iy = step_y > 0 ? height - 1 - j : j;
    std::uint32_t* row = sides.data() + static_cast<std::size_t>(iy) * width;
    int beside = longest_side, across = longest_side;
    for (int i = 0; i < width; ++i) {
      const int ix = step_x > 0 ? width - 1 - i : i;
      const int ahead = next_row[ix];
      const int side = grid.occupied({ix, iy}) ? 0 : std::min(std::min({beside, ahead, across}) + 1, longest_side);
      across = ahead;
      next_row[ix] = beside = side;
      row[ix] |= static_cast<std::uint32_t>(side) << shift;
    }
  }
}

}  // namespace

RayCaster::RayCaster(const OccupancyGrid& grid, double range_max) : geometry_(grid.geometry), range_max_(range_max) {
  require_positive("range_max", range_max, "m");
  const double cells = static_cast<double>(geometry_.width) * geometry_.height;
  require_between("number of cells", cells, 1, std::numeric_limits<std::int32_t>::max(), "");
  free_sides_.resize(static_cast<std::size_t>(cells));
  for (int quadrant = 0; quadrant < 4; ++quadrant)
    add_free_sides(grid, quadrant & 1 ? -1 : 1, quadrant & 2 ? -1 : 1, 8 * quadrant, free_sides_);
}

void RayCaster::cast(const Pose2& T_map_laser, std::span<const double> angles, std::span<float> ranges) const {
  require(angles.size() == ranges.size(), "ranges must be as many as angles");
  require_pose("T_map_laser", T_map_laser);
  Bundle bundle;
  bundle.x = (T_map_laser.x - geometry_.origin_x) / geometry_.resolution;
  bundle.y = (T_map_laser.y - geometry_.origin_y) / geometry_.resolution;
  for (std::size_t first = 0; first < angles.size(); first += lanes) {
    const std::size_t count = std::min<std::size_t>(lanes, angles.size() - first);
    double headings[lanes];
    for (std::size_t i = 0; i < lanes; ++i) {
      headings[i] = T_map_laser.yaw + angles[first + std::min(i, count - 1)];
      if (!std::isfinite(headings[i]))
        require_finite("heading of beam " + std::to_string(first + i), headings[i], "rad");
    }
    cosines(headings, bundle.dx);
    sines(headings, bundle.dy);
    enter(bundle, geometry_.width, geometry_.height, range_max_ / geometry_.resolution);
    while (leap(bundle, free_sides_.data(), geometry_.width, geometry_.height)) continue;
    for (std::size_t i = 0; i < count; ++i)
      ranges[first + i] = static_cast<float>(bundle.range[i] * geometry_.resolution);
  }
}

}  // namespace lfdcore
