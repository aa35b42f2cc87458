#include "common.hpp"

namespace lfdcore {

void bind_footprint_rollout(py::module_&) {}

}  // namespace lfdcore
