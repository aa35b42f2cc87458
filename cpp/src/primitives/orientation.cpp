#include "lfdcore/primitives/orientation.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

// Eigen's coefficients are x y z w too.
Eigen::Quaterniond unit(const Eigen::Vector4d& q, const std::string& name) {
  const double length = q.stableNorm();
  require(length >= 1e-9 && length <= 1e9,
          name + " has length " + std::to_string(length) + ", must be within [1e-9, 1e9]");
  return Eigen::Quaterniond(Eigen::Vector4d(q / length));
}

Eigen::Quaterniond unit_row(const RowMatrix& quaternions, Eigen::Index t, const char* name) {
  return unit(quaternions.row(t).transpose(), std::string(name) + "[" + std::to_string(t) + "]");
}

void require_columns(const RowMatrix& matrix, Eigen::Index columns, const char* name) {
  require(matrix.cols() == columns, std::string(name) + " has shape (" + std::to_string(matrix.rows()) + ", " +
                                        std::to_string(matrix.cols()) + "), must be (T, " + std::to_string(columns) +
                                        ")");
}

}  // namespace

RowMatrix continuous_quaternions(const RowMatrix& quaternions) {
  require_columns(quaternions, 4, "quaternions");
  RowMatrix result(quaternions.rows(), 4);
  Eigen::Vector4d last(0, 0, 0, 1);
  for (Eigen::Index t = 0; t < result.rows(); ++t) {
    const Eigen::Vector4d q = unit_row(quaternions, t, "quaternions").coeffs();
    last = q.dot(last) < 0 ? Eigen::Vector4d(-q) : q;
    result.row(t) = last;
  }
  return result;
}

RowMatrix imaginary_parts(const RowMatrix& quaternions, const Eigen::Vector4d& reference) {
  require_columns(quaternions, 4, "quaternions");
  const Eigen::Quaterniond back = unit(reference, "reference").conjugate();
  RowMatrix relative(quaternions.rows(), 4);
  for (Eigen::Index t = 0; t < relative.rows(); ++t)
    relative.row(t) = (back * unit_row(quaternions, t, "quaternions")).coeffs();
  relative = continuous_quaternions(relative);
  for (Eigen::Index t = 0; t < relative.rows(); ++t) {
    const double angle = 2 * std::atan2(relative.row(t).head<3>().norm(), relative(t, 3));
    require(relative(t, 3) >= -1e-12, "quaternions[" + std::to_string(t) + "] is turned by " + std::to_string(angle) +
                                          " rad from the reference, must be at most pi (3.141593) rad");
  }
  return relative.leftCols<3>();
}

RowMatrix quaternions_from_imaginary(const RowMatrix& parts, const Eigen::Vector4d& reference) {
  require_columns(parts, 3, "parts");
  require(parts.allFinite(), "parts has values that are not finite");
  const Eigen::Quaterniond start = unit(reference, "reference");
  RowMatrix result(parts.rows(), 4);
  for (Eigen::Index t = 0; t < result.rows(); ++t) {
    const double length = parts.row(t).stableNorm();
    const Eigen::Vector3d v = parts.row(t).transpose() / std::max(1.0, length);
    const double w = std::sqrt(std::max(0.0, 1 - v.squaredNorm()));
    result.row(t) = (start * Eigen::Quaterniond(w, v.x(), v.y(), v.z()).normalized()).coeffs();
  }
  return result;
}

Eigen::VectorXd geodesic_angle(const RowMatrix& a, const RowMatrix& b) {
  require_columns(a, 4, "a");
  require_columns(b, 4, "b");
  require(a.rows() == b.rows(), "a has " + std::to_string(a.rows()) + " rows and b has " + std::to_string(b.rows()));
  Eigen::VectorXd angles(a.rows());
  for (Eigen::Index t = 0; t < a.rows(); ++t) {
    const Eigen::Quaterniond between = unit_row(a, t, "a").conjugate() * unit_row(b, t, "b");
    angles[t] = 2 * std::atan2(between.vec().norm(), std::abs(between.w()));
  }
  return angles;
}

Eigen::Vector4d mean_orientation(const RowMatrix& quaternions) {
  require_columns(quaternions, 4, "quaternions");
  require(quaternions.rows() > 0, "quaternions is empty, must have a row at least");
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  for (Eigen::Index t = 0; t < quaternions.rows(); ++t) {
    const Eigen::Vector4d q = unit_row(quaternions, t, "quaternions").coeffs();
    sum += q * q.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(sum / static_cast<double>(quaternions.rows()));
  require(eigen.eigenvalues()[3] - eigen.eigenvalues()[2] > 1e-6,
          "no mean orientation stands out: the rotations are spread evenly");
  const Eigen::Vector4d mean = eigen.eigenvectors().col(3);
  return mean.w() < 0 ? Eigen::Vector4d(-mean) : mean;
}

}  // namespace lfdcore
