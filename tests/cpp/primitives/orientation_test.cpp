#include "lfdcore/primitives/orientation.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace lfdcore {
namespace {

TEST(Orientation, goes_to_imaginary_parts_and_back_whatever_the_signs) {
  RowMatrix quaternions(41, 4);
  for (int t = 0; t < 41; ++t) {
    const double half = 0.035 * (t - 20);  // up to 1.4 rad either way of the middle
    quaternions.row(t) << 0, std::sin(half + 1), 0, std::cos(half + 1);
    if (t % 3 == 0) quaternions.row(t) *= -2;
  }
  const Eigen::Vector4d middle = mean_orientation(quaternions);
  EXPECT_LT(geodesic_angle(middle.transpose(), quaternions.row(20))[0], 1e-7);
  const RowMatrix back = quaternions_from_imaginary(imaginary_parts(quaternions, middle), middle);
  EXPECT_LT(geodesic_angle(back, quaternions).maxCoeff(), 1e-7);
  EXPECT_NEAR(imaginary_parts(quaternions, middle)(40, 1), std::sin(0.7), 1e-12);
}

TEST(Orientation, refuses_quaternions_without_a_direction) {
  const RowMatrix zero = RowMatrix::Zero(2, 4);
  EXPECT_THROW(continuous_quaternions(zero), std::invalid_argument);
  EXPECT_THROW(mean_orientation(zero), std::invalid_argument);
  EXPECT_THROW(quaternions_from_imaginary(RowMatrix::Zero(1, 3), Eigen::Vector4d::Zero()), std::invalid_argument);
}

}  // namespace
}  // namespace lfdcore
