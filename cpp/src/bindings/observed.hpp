// Observed by its name.
#pragma once

#include <stdexcept>
#include <string>

#include "fields.hpp"
#include "lfdcore/primitives/dmp.hpp"

namespace lfdcore {

inline Observed observed_of(const std::string& argument, const std::string& name) {
  if (name == "forcing") return Observed::forcing;
  if (name == "positions") return Observed::positions;
  throw std::invalid_argument(argument + " is '" + name + "', must be forcing or positions");
}

inline const char* name_of(Observed observed) { return observed == Observed::forcing ? "forcing" : "positions"; }

template <>
struct Seen<Observed> {
  using Type = std::string;
  static std::string to_python(Observed observed) { return name_of(observed); }
  static Observed from_python(const char* field, const std::string& name) { return observed_of(field, name); }
};

}  // namespace lfdcore
