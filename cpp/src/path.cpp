#include "lfdcore/path.hpp"

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

constexpr Eigen::Index most_points = 1'000'000;

void require_points(const Path& path) {
  for (Eigen::Index i = 0; i < path.rows(); ++i) {
    if (path.row(i).allFinite()) continue;
    require(false, "path point " + std::to_string(i) + " is (" + std::to_string(path(i, 0)) + ", " +
                       std::to_string(path(i, 1)) + ") m, must be finite");
  }
}

}  // namespace

Eigen::VectorXd arc_length(const Path& path) {
  Eigen::VectorXd length = Eigen::VectorXd::Zero(path.rows());
  for (Eigen::Index i = 1; i < path.rows(); ++i) length(i) = length(i - 1) + (path.row(i) - path.row(i - 1)).norm();
  return length;
}

Path resample(const Path& path, Eigen::Index count) {
  require(path.rows() >= 1, "a path without points cannot be resampled");
  require_between("count", static_cast<double>(count), 2, most_points, "points");
  require_points(path);
  const Eigen::VectorXd length = arc_length(path);
  const double total = length(length.size() - 1);
  require_finite("length of the path", total, "m");
  Path result(count, 2);
  Eigen::Index segment = 0;
  for (Eigen::Index i = 0; i < count; ++i) {
    const double at = total * static_cast<double>(i) / static_cast<double>(count - 1);
    while (segment + 2 < path.rows() && length(segment + 1) < at) ++segment;
    const Eigen::Index next = std::min(segment + 1, path.rows() - 1);
    const double span = length(next) - length(segment);
    const double share = span > 0 ? std::clamp((at - length(segment)) / span, 0.0, 1.0) : 0.0;
    result.row(i) = (1 - share) * path.row(segment) + share * path.row(next);
  }
  return result;
}

Path transform(const Pose2& T_a_b, const Path& path) {
  const double c = std::cos(T_a_b.yaw), s = std::sin(T_a_b.yaw);
  Path result(path.rows(), 2);
  for (Eigen::Index i = 0; i < path.rows(); ++i) {
    const double x = path(i, 0), y = path(i, 1);
    result.row(i) << T_a_b.x + c * x - s * y, T_a_b.y + s * x + c * y;
  }
  return result;
}

}  // namespace lfdcore
