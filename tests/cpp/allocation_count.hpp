// How often this test program has called malloc, to test that a kernel's steady state does not allocate.
#pragma once

namespace lfdcore::test {

/// False where malloc belongs to a sanitizer or is not glibc's.
extern const bool counts_allocations;

/// Calls of malloc so far, Eigen's and operator new's among them; 0 where nothing counts.
long allocation_count();

}  // namespace lfdcore::test
