#include <mutex>
#include <optional>

#include "common.hpp"
#include "fields.hpp"
#include "lfdcore/primitives/dtw.hpp"
#include "lfdcore/primitives/open_end_dtw.hpp"
#include "lfdcore/primitives/orientation.hpp"
#include "lfdcore/primitives/phase_estimator.hpp"

namespace lfdcore {
namespace {

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

std::span<const double> view(const Doubles& array) { return {array.data(), static_cast<std::size_t>(array.size())}; }

// These have one state: calls from several threads wait for each other.
struct SharedDtw {
  OpenEndDtw dtw;
  std::mutex busy{};
};
struct SharedEstimator {
  PhaseEstimator estimator;
  std::mutex busy{};
};

// One series as (T, D): a (T,) array is one dimension.
RowMatrix series(const Doubles& array) {
  if (array.ndim() != 1 && array.ndim() != 2)
    throw py::value_error("a series has " + std::to_string(array.ndim()) + " axes, must be (T,) or (T, D)");
  const auto columns = array.ndim() == 2 ? array.shape(1) : 1;
  return Eigen::Map<const RowMatrix>(array.data(), array.shape(0), columns);
}

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
            return self.dtw.observe(at);
          },
          py::arg("sample"),
          "The next sample (D,) in O(n D). NaN in a dimension: not seen; the distance over the others is scaled by "
          "sqrt(D / seen). A sample without any seen dimension changes nothing. ValueError, and it stays as it was, "
          "for another D and for what is infinite or beyond 1e100.")
      .def(
          "reset",
          [](SharedDtw& self) {
            const std::lock_guard lock(self.busy);
            self.dtw.reset();
          },
          "Forgets all samples.")
      .def_property_readonly(
          "dimensions", [](const SharedDtw& self) { return self.dtw.dimensions(); }, "D")
      .def("__len__", [](const SharedDtw& self) { return self.dtw.size(); });
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

void bind_phase(py::module_& m) {
  using Config = PhaseEstimatorConfig;
  bind_settings(
      m, "PhaseEstimatorConfig", "How PhaseEstimator reads phase and tempo. ValueError names a field.",
      Field("phase_decay", &Config::phase_decay, "alpha_x > 0 of the DMPs' canonical system, ln 100"),
      Field("tempo_window", &Config::tempo_window, "the rate is of the last [s], 0 < .. <= 60"),
      Field("rest_share", &Config::rest_share, "no further from its start than this share of the way is rest"),
      Field("pause_rate", &Config::pause_rate, "slower than this share of the reference's tempo is a pause"));
  py::class_<PartnerPhase>(m, "PartnerPhase", "How far a partner has come, and how fast.")
      .def_readonly("index", &PartnerPhase::index, "t* - 1, row of the reference; -1 before any sample")
      .def_readonly("distance", &PartnerPhase::distance, "of the open-end DTW")
      .def_readonly("reference_time", &PartnerPhase::reference_time, "of that row [s]")
      .def_readonly("phase", &PartnerPhase::phase, "x* = exp(-alpha_x (t* - 1) / (n - 1)) (5.5, ERRATA 38)")
      .def_readonly("rate", &PartnerPhase::rate, "the tempo now, 1 = the reference's, >= 0; 1 until known")
      .def_readonly("mean_rate", &PartnerPhase::mean_rate,
                    "reference_time / time since the first sample (t* / T' of F14); 1 until determined")
      .def_readonly("determined", &PartnerPhase::determined,
                    "False while partner or reference still rest at their start: then index says nothing")
      .def_readonly("paused", &PartnerPhase::paused, "the partner stands still, or has come to the end");
  py::class_<SharedEstimator>(
      m, "PhaseEstimator",
      "How far a partner has come in a movement, and how fast (5.5, ERRATA 38). Open-end DTW gives t*: it does not "
      "care about tempo, a pausing partner leaves it where it is. The rate is the slope of t* over the last "
      "tempo_window: the line through the medians of its first and its last third, so that single jumps of t* do not "
      "count. The phase is determined, for good, once partner and reference have both gone further from their starts "
      "than rest_share of the reference's greatest distance from its own. Sample the reference about as densely as the "
      "partner: many more rows make t* lag.")
      .def(py::init([](const Doubles& reference, double duration, const Config& config) {
             return std::make_unique<SharedEstimator>(PhaseEstimator(series(reference), duration, config));
           }),
           py::arg("reference"), py::arg("duration"), py::arg("config") = Config{},
           "reference (n, D) evenly sampled over `duration` [s]. ValueError for n < 2, what is not finite and within "
           "1e100, a reference that never leaves its start, and a duration that is not > 0.")
      .def(
          "observe",
          [](SharedEstimator& self, double stamp, const Doubles& sample) {
            const auto at = view(sample);
            const py::gil_scoped_release free;
            const std::lock_guard lock(self.busy);
            return PartnerPhase(self.estimator.observe(stamp, at));
          },
          py::arg("stamp"), py::arg("sample"),
          "The partner's sample (D,) at stamp [s]; NaN as in OpenEndDtw: one without any seen dimension changes "
          "nothing but the clock. ValueError, and it stays as it was, for a stamp that is not finite or not later than "
          "the last and for samples that OpenEndDtw refuses.")
      .def(
          "reset",
          [](SharedEstimator& self) {
            const std::lock_guard lock(self.busy);
            self.estimator.reset();
          },
          "Forgets all samples.")
      .def_property_readonly("config", [](const SharedEstimator& self) { return self.estimator.config(); })
      .def_property_readonly(
          "duration", [](const SharedEstimator& self) { return self.estimator.duration(); }, "[s]")
      .def_property_readonly(
          "dimensions", [](const SharedEstimator& self) { return self.estimator.dimensions(); }, "D")
      .def("__len__", [](const SharedEstimator& self) { return self.estimator.size(); });
}

void bind_orientation(py::module_& m) {
  m.def("continuous_quaternions", &continuous_quaternions, py::arg("quaternions"),
        "(T, 4) x y z w -> the same rotations of length 1, the first with w >= 0, each on its predecessor's side "
        "(ERRATA 44). Steps of half a turn are ambiguous. ValueError for a length that is not within [1e-9, 1e9].");
  m.def("imaginary_parts", &imaginary_parts, py::arg("quaternions"), py::arg("reference"),
        "(T, 4), (4,) -> (T, 3): imaginary parts of conj(reference) q with w >= 0, that is axis * sin(angle / 2) in "
        "the reference's frame. ValueError, naming sample and angle, where a series, followed without jumps from its "
        "first sample, turns beyond pi from the reference: take mean_orientation of it.");
  m.def("quaternions_from_imaginary", &quaternions_from_imaginary, py::arg("parts"), py::arg("reference"),
        "Inverse of imaginary_parts: (T, 3), (4,) -> (T, 4) of length 1, w = sqrt(max(0, 1 - |v|^2)) (ERRATA 44): "
        "parts longer than 1 count as half a turn about their axis. ValueError for what is not finite.");
  m.def("geodesic_angle", &geodesic_angle, py::arg("a"), py::arg("b"),
        "(T, 4), (T, 4) -> (T,) angles in [0, pi] [rad] between rows. ValueError for other shapes and zero lengths.");
  m.def("mean_orientation", &mean_orientation, py::arg("quaternions"),
        "(T, 4) -> (4,) with w >= 0: the rotation with the least sum of squared chordal distances (largest "
        "eigenvector of sum q q'). ValueError for no rows and where no mean stands out.");
}

}  // namespace

void bind_dtw(py::module_& m) {
  bind_offline(m);
  bind_open_end(m);
  bind_phase(m);
  bind_orientation(m);
}

}  // namespace lfdcore
