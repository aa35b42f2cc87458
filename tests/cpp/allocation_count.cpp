#include "allocation_count.hpp"

#include <atomic>
#include <cstddef>

namespace {
std::atomic<long> calls{0};
}

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
#define LFDCORE_COUNTS true
extern "C" {
void* __libc_malloc(std::size_t size);
void* malloc(std::size_t size) {
  calls.fetch_add(1, std::memory_order_relaxed);
  return __libc_malloc(size);
}
}
#else
#define LFDCORE_COUNTS false
#endif

namespace lfdcore::test {

const bool counts_allocations = LFDCORE_COUNTS;

long allocation_count() { return calls.load(std::memory_order_relaxed); }

}  // namespace lfdcore::test
