// How often this test program has called malloc, to test that a kernel's steady state does not allocate.
#pragma once

namespace lfdcore::test {

/// Calls of malloc so far, Eigen's and operator new's among them; always 0 under a sanitizer, which owns malloc.
long allocation_count();

}  // namespace lfdcore::test
