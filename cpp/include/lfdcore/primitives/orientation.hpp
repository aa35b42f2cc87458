// Orientations as unit quaternions x y z w, and as the three numbers that primitives learn (Sec. 5.6, ERRATA 44).
#pragma once

#include <Eigen/Geometry>

#include "lfdcore/row_matrix.hpp"

namespace lfdcore {

// In all of these a quaternion need not have length 1, only a direction: std::invalid_argument, naming the row, where
// it is not finite or its length is not within [1e-9, 1e9].

/// (T, 4) of length 1 for the same rotations: the first with w >= 0, each on its predecessor's side (dot product >= 0).
/// Steps of half a turn between samples are ambiguous.
RowMatrix continuous_quaternions(const RowMatrix& quaternions);

/// (T, 3): imaginary parts of conj(reference) q_t with w >= 0, that is axis * sin(angle / 2) in the reference's frame.
/// This holds rotations up to pi from the reference: throws std::invalid_argument, naming the sample and the angle,
/// where a series, followed without jumps from its first sample, turns beyond; take a reference amid the series then
/// (mean_orientation).
RowMatrix imaginary_parts(const RowMatrix& quaternions, const Eigen::Vector4d& reference);

/// Inverse of imaginary_parts, (T, 3) -> (T, 4) of length 1: w = sqrt(max(0, 1 - |v|^2)), so that parts longer than 1,
/// as a model may predict, count as half a turn about their axis. Throws std::invalid_argument for what is not finite.
RowMatrix quaternions_from_imaginary(const RowMatrix& parts, const Eigen::Vector4d& reference);

/// (T,) angles in [0, pi] [rad] of the rotations between rows of a and of b, both (T, 4).
Eigen::VectorXd geodesic_angle(const RowMatrix& a, const RowMatrix& b);

/// Of length 1 with w >= 0: the rotation with the least sum of squared chordal distances to the rows (largest
/// eigenvector of sum q q'; Markley et al. 2007). Throws std::invalid_argument for no rows and where no mean stands
/// out, as of two orientations half a turn apart.
Eigen::Vector4d mean_orientation(const RowMatrix& quaternions);

}  // namespace lfdcore
