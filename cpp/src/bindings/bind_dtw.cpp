#include <mutex>
#include <optional>

#include "arrays.hpp"
#include "common.hpp"
#include "lfdcore/primitives/dtw.hpp"
#include "lfdcore/primitives/open_end_dtw.hpp"
#include "shared.hpp"

namespace lfdcore {
namespace {

using SharedDtw = Shared<OpenEndDtw>;

void bind_offline(py::module_& m) {
  py::class_<DtwResult>(m, "DtwResult", "An alignment of two series of m and n samples.")
      .def_readonly("distance", &DtwResult::distance, "D(m, n), in the series' unit")
      .def_readonly("costs", &DtwResult::costs, "(m, n) accumulated costs, inf outside the window; a view")
      .def_readonly("path", &DtwResult::path, "(K, 2) int64 rows that correspond, (0, 0) to (m - 1, n - 1); a view");
  m.def(
      "dtw",
      [](const Doubles& a, const Doubles& b, std::optional<int> window) {
        const RowMatrix first = series(a), second = series(b);
        const py::gil_scoped_release free;
        return dtw(first, second, window);
      },
      py::arg("a"), py::arg("b"), py::arg("window") = py::none(),
      "Alg. 9 (ERRATA 49): aligns a (m, D) and b (n, D), or (m,) and (n,), by Euclidean distance. window: only |i - j| "
      "<= window counts (Sakoe-Chiba). Among equal predecessors the path prefers (i-1, j-1), then (i-1, j), then "
      "(i, j-1). Takes 8 m n bytes. ValueError for series that are empty, of different D or not finite and within "
      "1e100, and for a window narrower than |m - n|.");
  m.def(
      "dtw_distance",
      [](const Doubles& a, const Doubles& b, std::optional<int> window) {
        const RowMatrix first = series(a), second = series(b);
        const py::gil_scoped_release free;
        return dtw_distance(first, second, window);
      },
      py::arg("a"), py::arg("b"), py::arg("window") = py::none(),
      "dtw(a, b, window).distance, the same to the last bit, in O(m + n) memory.");
}

void bind_open_end(py::module_& m) {
  py::class_<OpenEndPhase>(m, "OpenEndPhase", "Where in the reference a partial series has come to.")
      .def_readonly("index", &OpenEndPhase::index,
                    "t* - 1: row of the reference, argmin_j D(m, j), ties to the smallest; -1 before any sample")
      .def_readonly("distance", &OpenEndPhase::distance, "D(m, t*), in the series' unit");
  py::class_<SharedDtw>(m, "OpenEndDtw",
                        "Dynamic time warping whose end in the reference is open, sample by sample (Sec. 5.3.1, "
                        "ERRATA 49).")
      .def(
          py::init([](const Doubles& reference) { return std::make_unique<SharedDtw>(OpenEndDtw(series(reference))); }),
          py::arg("reference"), "(n, D) or (n,). ValueError if it is empty or not finite and within 1e100.")
      .def(
          "observe",
          [](SharedDtw& self, const Doubles& sample) {
            const auto at = view(sample);
            const py::gil_scoped_release free;
            const std::lock_guard lock(self.busy);
            return self.value.observe(at);
          },
          py::arg("sample"),
          "The next sample (D,) in O(n D). NaN in a dimension: not seen; the distance over the others is scaled by "
          "sqrt(D / seen). A sample without any seen dimension changes nothing. ValueError, and it stays as it was, "
          "for another D and for what is infinite or beyond 1e100.")
      .def(
          "reset",
          [](SharedDtw& self) {
            const std::lock_guard lock(self.busy);
            self.value.reset();
          },
          "Forgets all samples.")
      .def_property_readonly(
          "dimensions", [](const SharedDtw& self) { return self.value.dimensions(); }, "D")
      .def("__len__", [](const SharedDtw& self) { return self.value.size(); });
  m.def(
      "open_end_dtw",
      [](const Doubles& query, const Doubles& reference) {
        const RowMatrix first = series(query), second = series(reference);
        const py::gil_scoped_release free;
        return open_end_dtw(first, second);
      },
      py::arg("query"), py::arg("reference"),
      "The OpenEndPhase after all samples of query (m, D) or (m,); NaN and errors as in OpenEndDtw.");
}

}  // namespace

void bind_dtw(py::module_& m) {
  bind_offline(m);
  bind_open_end(m);
}

}  // namespace lfdcore
