// What has a state and is asked from Python's threads.
#pragma once

#include <mutex>

namespace lfdcore {

/// A value and its lock: it has one state, so calls from several threads wait for each other.
template <class Value>
struct Shared {
  Value value;
  mutable std::mutex busy{};
};

}  // namespace lfdcore
