#include "lfdcore/planning/user_heatmap.hpp"

#include <algorithm>
#include <cmath>

#include "lfdcore/error.hpp"
#include "orientation_kernel.hpp"

namespace lfdcore {
namespace {

void validate(const OrientationMoments& orientation) {
  require_finite("orientation mean", orientation.mean, "rad");
  require_between("orientation variance", orientation.variance, 1e-6, 1e6, "rad^2");
}

void validate(const StickMoments& stick) {
  require_finite("forward mean", stick.forward, "of full stick");
  require_finite("left mean", stick.left, "of full stick");
  require_between("forward variance", stick.forward_variance, 0, 1e300, "of full stick squared");
  require_between("left variance", stick.left_variance, 0, 1e300, "of full stick squared");
}

}  // namespace

std::optional<OrientationMoments> joystick_orientation(const StickMoments& stick) {
  validate(stick);
  const double radius = std::hypot(stick.forward, stick.left);
  if (radius < stick_centre) return std::nullopt;
  const double along = stick.forward / radius, across = stick.left / radius;
  const double spread = std::hypot(std::sqrt(stick.left_variance) * along, std::sqrt(stick.forward_variance) * across);
  const double sd = std::clamp(spread / radius, smallest_orientation_sd, largest_orientation_sd);  // 4.2
  return OrientationMoments{wrap_angle(std::atan2(stick.left, stick.forward)), sd * sd};           // 4.1
}

// The largest weight is taken out of the exponents, so that the heatmap has a maximum of 1 also where all densities
// underflow.
void user_heatmap(const MovementTemplate& movement, const OrientationMoments& orientation, UserHeatmap& result) {
  validate(orientation);
  const FloatGrid &cells = movement.orientation(), &filter = movement.distance_filter();
  const auto count = static_cast<std::size_t>(cells.size());
  result.density.resizeLike(cells);
  result.heatmap.resizeLike(cells);
  const auto mean = static_cast<float>(wrap_angle(orientation.mean));
  detail::wrapped_squares(cells.data(), mean, result.density.data(), count);
  const float nearest = result.density.minCoeff();
  const double scale = 0.5 / orientation.variance;
  detail::weigh_squares(result.density.data(), nearest, static_cast<float>(scale), filter.data(), result.heatmap.data(),
                        count);
  const double peak = std::exp(-scale * nearest) / std::sqrt(2 * pi * orientation.variance);
  result.density *= static_cast<float>(peak);   // 4.3
  result.heatmap /= result.heatmap.maxCoeff();  // not times the reciprocal, which would round beyond 1
}

double compliance(const Eigen::Vector2d& control_point, const OrientationMoments& orientation,
                  const MotionLimits& limits) {
  validate(orientation);
  validate(limits);
  if (control_point.isZero(0)) return 1;
  const double error = wrap_angle(orientation.mean - arc_orientation(control_point, limits));
  return std::exp(-0.5 * error * error / orientation.variance);
}

}  // namespace lfdcore
