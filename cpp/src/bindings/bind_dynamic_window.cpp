#include "common.hpp"

namespace lfdcore {

void bind_dynamic_window(py::module_&) {}

}  // namespace lfdcore
