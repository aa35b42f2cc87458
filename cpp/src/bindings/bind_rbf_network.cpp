#include "common.hpp"

namespace lfdcore {

void bind_rbf_network(py::module_&) {}

}  // namespace lfdcore
