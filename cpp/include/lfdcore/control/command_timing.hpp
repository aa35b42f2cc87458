// When commands come: a property of the chair and its loop, which no controller chooses.
#pragma once

namespace lfdcore {

/// The next command acts between `period` and `period` + `jitter` after this one.
struct CommandTiming {
  double period = 0.1;   ///< between two commands [s]
  double jitter = 0.05;  ///< by which the next one may come late [s]
};

/// Throws std::invalid_argument, naming the field, for a period outside (0, 10] s or a jitter outside [0, 10] s.
void validate(const CommandTiming& timing);

}  // namespace lfdcore
