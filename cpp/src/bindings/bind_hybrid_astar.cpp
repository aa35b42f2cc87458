#include "common.hpp"

namespace lfdcore {

void bind_hybrid_astar(py::module_&) {}

}  // namespace lfdcore
