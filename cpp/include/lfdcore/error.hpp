// Errors and argument checks. In Python: std::invalid_argument is ValueError, the others are lfdcore.errors classes.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace lfdcore {

/// A file or a stream that cannot be what it claims to be (truncated, garbled, wrong format).
struct DataError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A learned model that cannot be used (wrong version, resolution or frame).
struct ModelError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A device that cannot be used (missing, taken, without permission, gone, not what it should be), and what to do.
struct DeviceError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Throws std::invalid_argument("<name> is <value> <unit>, must be finite").
void require_finite(std::string_view name, double value, std::string_view unit);

/// Throws std::invalid_argument unless value > 0 and finite.
void require_positive(std::string_view name, double value, std::string_view unit);

/// Throws std::invalid_argument unless low <= value <= high; names the value, the bounds and the unit.
void require_between(std::string_view name, double value, double low, double high, std::string_view unit);

/// Throws std::invalid_argument(message) unless the condition holds.
void require(bool condition, const std::string& message);

/// The same for a literal: builds no string, and so allocates nothing, while the condition holds.
inline void require(bool condition, const char* message) {
  if (!condition) throw std::invalid_argument(message);
}

}  // namespace lfdcore
