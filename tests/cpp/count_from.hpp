// How much of a test is run: a number from the environment.
#pragma once

#include <cstdlib>

namespace lfdcore::test {

inline long count_from(const char* variable, long otherwise) {
  const char* text = std::getenv(variable);
  return text ? std::atol(text) : otherwise;
}

}  // namespace lfdcore::test
