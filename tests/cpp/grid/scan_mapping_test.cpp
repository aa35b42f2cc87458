#include "lfdcore/grid/scan_mapping.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>

namespace lfdcore {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr double range_min = 0.25, range_max = 8;

// Every kind of range that a scanner may give, and what it means.
struct Meaning {
  float range;
  double length;
  bool hit;
};
constexpr std::array<Meaning, 11> meanings{{{nan, 0, false},
                                            {-infinity, range_min, true},
                                            {infinity, range_max, false},
                                            {0, 0, false},
                                            {-3, 0, false},
                                            {0.125f, 0, false},
                                            {0.25f, 0.25, true},
                                            {2, 2, true},
                                            {7.75f, 7.75, true},
                                            {8, range_max, false},
                                            {40, range_max, false}}};

TEST(ReadBeam, gives_every_kind_of_range_its_one_meaning) {
  for (const auto& [range, length, hit] : meanings) {
    const Beam beam = read_beam(range, range_min, range_max);
    EXPECT_EQ(beam.length, length) << range;
    EXPECT_EQ(beam.hit, hit) << range;
  }
}

TEST(ReadBeam, takes_0_for_a_hit_where_the_scanner_measures_from_0_on) {
  EXPECT_TRUE(read_beam(0, 0, range_max).hit);
  EXPECT_FALSE(read_beam(-0.5, 0, range_max).hit);
}

TEST(ReadBeams, reads_each_range_as_read_beam_does) {
  LaserScan scan{{}, 0, 0.1, range_min, range_max};
  for (const Meaning& one : meanings) scan.ranges.push_back(one.range);
  std::array<double, meanings.size()> lengths;
  std::array<bool, meanings.size()> hit;
  read_beams(scan.ranges, range_min, range_max, lengths, hit);
  for (std::size_t i = 0; i < meanings.size(); ++i) {
    EXPECT_EQ(lengths[i], read_beam(scan, i).length);
    EXPECT_EQ(hit[i], read_beam(scan, i).hit);
  }
}

TEST(ReadBeams, refuses_limits_that_cannot_be_and_spans_of_other_lengths) {
  const std::array<float, 2> ranges{1, 2};
  std::array<double, 2> lengths;
  std::array<bool, 2> hit;
  EXPECT_THROW(read_beams(ranges, -0.1, 8, lengths, hit), std::invalid_argument);
  EXPECT_THROW(read_beams(ranges, nan, 8, lengths, hit), std::invalid_argument);
  EXPECT_THROW(read_beams(ranges, 8, 8, lengths, hit), std::invalid_argument);
  EXPECT_THROW(read_beams(ranges, 0, infinity, lengths, hit), std::invalid_argument);
  EXPECT_THROW(read_beams(ranges, 0, 8, std::span(lengths).first(1), hit), std::invalid_argument);
  EXPECT_THROW(read_beams(ranges, 0, 8, lengths, std::span(hit).first(1)), std::invalid_argument);
}

TEST(LocalGrid, marks_what_read_beam_calls_a_hit_and_nothing_where_it_says_nothing) {
  for (const auto& [range, length, hit] : meanings) {
    const OccupancyGrid grid = local_grid({{range}, 0, 0.1, range_min, 2.5}, {0.01, 0.01, 0});
    const Beam beam = read_beam(range, range_min, 2.5);
    EXPECT_EQ((grid.data == occupied_cell).any(), beam.hit) << range;
    EXPECT_EQ((grid.data != unknown_cell).any(), beam.length > 0) << range;
  }
}

}  // namespace
}  // namespace lfdcore
