#include "common.hpp"

namespace lfdcore {

void bind_supervisor(py::module_&) {}

}  // namespace lfdcore
