// What a fuzz target claims.
#pragma once

#include <cstdio>
#include <cstdlib>

inline void require_true(bool claim, const char* what) {
  if (claim) return;
  std::fprintf(stderr, "broken: %s\n", what);
  std::abort();
}
