#include "common.hpp"

namespace lfdcore {

void bind_simulation(py::module_&) {}

}  // namespace lfdcore
