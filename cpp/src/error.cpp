#include "lfdcore/error.hpp"

#include <cmath>
#include <sstream>

namespace lfdcore {
namespace {

[[noreturn]] void refuse(std::string_view name, double value, std::string_view unit, const std::string& bound) {
  std::ostringstream text;
  text << name << " is " << value;
  if (!unit.empty()) text << ' ' << unit;
  text << ", must be " << bound;
  throw std::invalid_argument(text.str());
}

}  // namespace

void require_finite(std::string_view name, double value, std::string_view unit) {
  if (!std::isfinite(value)) refuse(name, value, unit, "finite");
}

void require_positive(std::string_view name, double value, std::string_view unit) {
  if (!(value > 0) || !std::isfinite(value)) refuse(name, value, unit, "positive and finite");
}

void require_between(std::string_view name, double value, double low, double high, std::string_view unit) {
  if (value >= low && value <= high) return;
  std::ostringstream bound;
  bound << "between " << low << " and " << high;
  refuse(name, value, unit, bound.str());
}

void require(bool condition, const std::string& message) {
  if (!condition) throw std::invalid_argument(message);
}

}  // namespace lfdcore
