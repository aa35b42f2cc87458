#include "lfdcore/control/side_contact.hpp"

namespace lfdcore {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

void SideContact::look() { points_.clear(); }

// Without a wall so near, what was held counts no more. A wall that comes nearer from there on is held at `near`, from
// where least() allows nothing that its points' uncertainties do not.
void SideContact::measure(double span, bool may_touch) {
  may_touch_ = may_touch;
  const double now = level(span);
  if (now < near)
    held_ = std::max(held_, now);
  else
    let_go();
}

double SideContact::level(double span) {
  std::sort(points_.begin(), points_.end(), [](const Point& a, const Point& b) { return a.beside < b.beside; });
  double rearmost = infinity, foremost = -infinity;
  for (const Point& point : points_) {
    rearmost = std::min(rearmost, point.ahead);
    foremost = std::max(foremost, point.ahead);
    if (foremost - rearmost >= span) return point.beside;
  }
  return infinity;
}

double SideContact::least(double uncertainty) const {
  if (!may_touch_ || held_ == -infinity) return infinity;
  return std::max(held_, -deepest) - allowance(uncertainty) - roughness;
}

}  // namespace lfdcore
