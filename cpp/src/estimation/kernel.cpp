#include "lfdcore/estimation/kernel.hpp"

#include <cmath>
#include <limits>
#include <string>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

constexpr double smallest = 1e-150, largest = 1e150;  // so that squares and reciprocals are numbers

double of_distance(KernelFamily family, double r) {
  if (family == KernelFamily::squared_exponential) return std::exp(-0.5 * r * r);  // C.5
  const double s = std::sqrt(family == KernelFamily::matern_3_2 ? 3.0 : 5.0) * r;  // C.6
  return (1 + s + (family == KernelFamily::matern_3_2 ? 0 : s * s / 3)) * std::exp(-s);
}

}  // namespace

void validate(const Kernel& kernel) {
  require_positive("amplitude", kernel.amplitude, "");
  require_between("amplitude", kernel.amplitude, smallest, largest, "");
  require(kernel.lengthscales.size() > 0, "a kernel needs a length-scale for every input dimension, got none");
  for (const double l : kernel.lengthscales) {
    require_positive("a length-scale", l, "");
    require_between("a length-scale", l, smallest, std::numeric_limits<double>::max(), "");
  }
}

RowMatrix covariance(const Kernel& kernel, const RowMatrix& a, const RowMatrix& b) {
  validate(kernel);
  const auto D = kernel.lengthscales.size();
  require(a.cols() == D && b.cols() == D, "inputs have " + std::to_string(a.cols()) + " and " +
                                              std::to_string(b.cols()) + " columns, the kernel has " +
                                              std::to_string(D) + " length-scales");
  const Eigen::ArrayXd scale = kernel.lengthscales.array().inverse();
  RowMatrix values(a.rows(), b.rows());
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    for (Eigen::Index j = 0; j < b.rows(); ++j) {
      const double r = ((a.row(i) - b.row(j)).transpose().array() * scale).matrix().norm();
      values(i, j) = kernel.amplitude * kernel.amplitude * of_distance(kernel.family, r);
    }
  return values;
}

}  // namespace lfdcore
