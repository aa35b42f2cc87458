#include <mutex>

#include "arrays.hpp"
#include "common.hpp"
#include "fields.hpp"
#include "lfdcore/primitives/phase_estimator.hpp"
#include "shared.hpp"

namespace lfdcore {
namespace {

using Config = PhaseEstimatorConfig;

using SharedEstimator = Shared<PhaseEstimator>;

void bind_config(py::module_& m) {
  bind_settings(
      m, "PhaseEstimatorConfig", "How PhaseEstimator reads phase and tempo. ValueError names a field.",
      Field("phase_decay", &Config::phase_decay, "alpha_x > 0 of the DMPs' canonical system, ln 100"),
      Field("tempo_window", &Config::tempo_window, "the rate is of the last [s], 0 < .. <= 60"),
      Field("rest_share", &Config::rest_share, "no further from its start than this share of the way is rest"),
      Field("pause_rate", &Config::pause_rate, "slower than this share of the reference's tempo is a pause"));
}

void bind_phase(py::module_& m) {
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
}

void bind_estimator(py::module_& m) {
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
            return PartnerPhase(self.value.observe(stamp, at));
          },
          py::arg("stamp"), py::arg("sample"),
          "The partner's sample (D,) at stamp [s]; NaN as in OpenEndDtw: one without any seen dimension changes "
          "nothing but the clock. ValueError, and it stays as it was, for a stamp that is not finite or not later than "
          "the last and for samples that OpenEndDtw refuses.")
      .def(
          "reset",
          [](SharedEstimator& self) {
            const std::lock_guard lock(self.busy);
            self.value.reset();
          },
          "Forgets all samples.")
      .def_property_readonly("config", [](const SharedEstimator& self) { return self.value.config(); })
      .def_property_readonly(
          "duration", [](const SharedEstimator& self) { return self.value.duration(); }, "[s]")
      .def_property_readonly(
          "dimensions", [](const SharedEstimator& self) { return self.value.dimensions(); }, "D")
      .def("__len__", [](const SharedEstimator& self) { return self.value.size(); });
}

}  // namespace

void bind_phase_estimator(py::module_& m) {
  bind_config(m);
  bind_phase(m);
  bind_estimator(m);
}

}  // namespace lfdcore
