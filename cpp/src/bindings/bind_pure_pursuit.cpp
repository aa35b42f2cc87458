#include "common.hpp"

namespace lfdcore {

void bind_pure_pursuit(py::module_&) {}

}  // namespace lfdcore
