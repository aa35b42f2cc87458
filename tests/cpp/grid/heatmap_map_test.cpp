#include "lfdcore/grid/heatmap_map.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

namespace lfdcore {
namespace {

const OccupancyGrid map({200, 180, 0.05, -5, -4}, free_cell);
const FloatGrid even = FloatGrid::Constant(100, 100, 0.25f);
const Mask all = Mask::Constant(100, 100, true);

TEST(HeatmapMap, counts_every_cell_that_falls_into_one_of_the_map) {
  HeatmapMap turned(map);
  EXPECT_EQ(turned.insert(even, all, {0, 0, 0.3}), 0);
  EXPECT_EQ(turned.count().sum(), 10000);
  EXPECT_GT(turned.count().maxCoeff(), 1);
  EXPECT_TRUE((turned.count() == 0 || turned.heatmap() == 1.0f).all());
}

TEST(HeatmapMap, reports_cells_outside_the_map) {
  HeatmapMap off(map);
  EXPECT_EQ(off.insert(even, all, {5, 0, 0}), 5000);
  EXPECT_EQ(off.count().sum(), 5000);
  EXPECT_EQ(off.insert(even, all, {1e6, 0, 0}), 10000);
}

TEST(HeatmapMap, adds_nothing_when_it_refuses) {
  HeatmapMap refusing(map);
  FloatGrid bad = even;
  bad(99, 99) = std::nanf("");
  EXPECT_THROW(refusing.insert(bad, all, {}), std::invalid_argument);
  EXPECT_THROW(refusing.insert(even, Mask::Constant(100, 99, true), {}), std::invalid_argument);
  EXPECT_THROW(refusing.insert(even, all, {0, 0, std::nan("")}), std::invalid_argument);
  EXPECT_EQ(refusing.count().sum(), 0);
}

}  // namespace
}  // namespace lfdcore
