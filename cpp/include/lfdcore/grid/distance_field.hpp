// Exact Euclidean distances on a grid (Felzenszwalb & Huttenlocher, Distance Transforms of Sampled Functions, 2012).
#pragma once

#include "lfdcore/grid/grid.hpp"

namespace lfdcore {

/// (height, width) [m]: from each cell's centre to the nearest occupied cell's centre; 0 in occupied cells, infinity
/// everywhere if none is occupied. Throws std::invalid_argument for an empty mask or a resolution [m] not positive.
FloatGrid distance_field(const Mask& occupied, double resolution);

/// (height, width): true where an occupied cell's centre lies within `radius` [m] of the cell's centre.
/// Throws std::invalid_argument for an empty mask, a negative radius or a resolution [m] not positive.
Mask inflate(const Mask& occupied, double radius, double resolution);

}  // namespace lfdcore
