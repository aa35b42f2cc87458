#include "lfdcore/planning/grid_mdp.hpp"

#include <gtest/gtest.h>

namespace lfdcore {
namespace {

TEST(GridMdp, moves_out_of_the_grid_stay) {
  const GridMdp mdp(FloatGrid::Zero(2, 3));
  EXPECT_EQ(mdp.successor({2, 0}, 8), (Cell{2, 0}));
  EXPECT_EQ(mdp.successor({1, 0}, 6), (Cell{0, 1}));
  EXPECT_EQ(mdp.successor({1, 1}, stay_action), (Cell{1, 1}));
}

TEST(GridMdp, cuts_a_corner_but_does_not_pass_between_two_blocked_cells) {
  GridMdp mdp(FloatGrid::Zero(2, 2));
  mdp.blocked(0, 1) = true;
  EXPECT_TRUE(mdp.available({0, 0}, 8));
  mdp.blocked(1, 0) = true;
  EXPECT_FALSE(mdp.available({0, 0}, 8));
  EXPECT_FALSE(mdp.available({0, 0}, 5));
  EXPECT_TRUE(mdp.available({0, 0}, stay_action));
  EXPECT_FALSE(mdp.available({1, 0}, stay_action));
}

}  // namespace
}  // namespace lfdcore
