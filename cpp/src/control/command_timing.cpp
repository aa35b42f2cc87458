#include "lfdcore/control/command_timing.hpp"

#include "lfdcore/error.hpp"

namespace lfdcore {

void validate(const CommandTiming& timing) {
  constexpr double longest = 10;  // [s]
  require_positive("period", timing.period, "s");
  require_between("period", timing.period, 0, longest, "s");
  require_between("jitter", timing.jitter, 0, longest, "s");
}

}  // namespace lfdcore
