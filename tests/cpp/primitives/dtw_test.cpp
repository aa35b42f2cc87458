#include "lfdcore/primitives/dtw.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "random_walk.hpp"

namespace lfdcore {
namespace {

using test::walk;

// Alg. 9 with the border of ERRATA 49.
RowMatrix table(const RowMatrix& a, const RowMatrix& b, int window) {
  RowMatrix D = RowMatrix::Constant(a.rows() + 1, b.rows() + 1, std::numeric_limits<double>::infinity());
  D(0, 0) = 0;
  for (Eigen::Index i = 1; i < D.rows(); ++i)
    for (Eigen::Index j = 1; j < D.cols(); ++j)
      if (std::abs(i - j) <= window)
        D(i, j) = (a.row(i - 1) - b.row(j - 1)).norm() + std::min({D(i - 1, j - 1), D(i - 1, j), D(i, j - 1)});
  return D.bottomRightCorner(a.rows(), b.rows());
}

TEST(Dtw, is_the_plain_table_at_every_shape_around_the_strips) {
  for (const int m : {1, 2, 63, 64, 65, 130})
    for (const int n : {1, 7, 64, 129})
      for (const int dimensions : {1, 2, 5, 6}) {
        const RowMatrix a = walk(m, dimensions, 1), b = walk(n, dimensions, 2);
        for (const int beyond : {0, 1, 10, 200}) {
          const int window = std::abs(m - n) + beyond;
          const RowMatrix costs = table(a, b, window);
          const DtwResult result = dtw(a, b, window);
          for (Eigen::Index i = 0; i < m; ++i)
            for (Eigen::Index j = 0; j < n; ++j)
              if (std::isfinite(costs(i, j)))
                ASSERT_NEAR(result.costs(i, j), costs(i, j), 1e-12 * costs(i, j));
              else
                ASSERT_EQ(result.costs(i, j), costs(i, j));
          ASSERT_EQ(dtw_distance(a, b, window), result.distance);
        }
      }
}

TEST(Dtw, refuses_a_window_that_no_path_can_keep_to) {
  EXPECT_THROW(dtw(walk(5, 1, 0), walk(8, 1, 0), 2), std::invalid_argument);
  EXPECT_NO_THROW(dtw(walk(5, 1, 0), walk(8, 1, 0), 3));
}

}  // namespace
}  // namespace lfdcore
