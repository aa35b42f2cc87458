// For tests that claim a real-time step allocates nothing.
#pragma once

/// Calls of operator new in this program so far (Eigen's own arrays call malloc and are not seen).
long allocations_so_far();
