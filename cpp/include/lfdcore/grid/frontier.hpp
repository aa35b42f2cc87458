// The edge of the regions of a mask that are not merely cracks.
#pragma once

#include "lfdcore/grid/grid.hpp"

namespace lfdcore {

/// The union of all squares of `width` x `width` cells (width odd) that lie wholly in the mask, or that reach beyond
/// its border and lie in it as far as they are inside (morphological opening).
Mask open_mask(const Mask& mask, int width);

/// The cells with a cell of the mask at most `reach` cells away along rows and along columns (dilation by a square).
Mask grown_mask(const Mask& mask, int reach);

/// The cells of the mask that have a cell outside the mask to the left, right, above or below; the border is not one.
Mask edge_of(const Mask& mask);

}  // namespace lfdcore
