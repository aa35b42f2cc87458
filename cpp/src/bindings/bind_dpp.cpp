#include "common.hpp"

namespace lfdcore {

void bind_dpp(py::module_&) {}

}  // namespace lfdcore
