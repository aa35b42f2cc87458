// Paths: polylines in the plane, points as rows [m].
#pragma once

#include <Eigen/Core>

#include "lfdcore/geometry.hpp"

namespace lfdcore {

/// (N, 2): x, y [m]
using Path = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;
/// (N, 3): x, y [m], yaw [rad]
using PosePath = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// Distance [m] travelled up to each point, (N,); the first is 0.
Eigen::VectorXd arc_length(const Path& path);

/// The path at `count` (2 to 1 000 000) points equally spaced by arc length. A path of one point repeats it.
/// Throws std::invalid_argument for other counts, no points, and points or a length that are not finite.
Path resample(const Path& path, Eigen::Index count);

/// The path's points in frame a, given in frame b.
Path transform(const Pose2& T_a_b, const Path& path);

}  // namespace lfdcore
