// Exact Euclidean distance from every cell to the nearest occupied one.
#pragma once

#include "lfdcore/grid/grid.hpp"

namespace lfdcore {

/// (height, width) [m]: from each cell's centre to the nearest occupied cell's centre; infinity where there is none.
FloatGrid distance_field(const Mask& occupied, double resolution);

}  // namespace lfdcore
