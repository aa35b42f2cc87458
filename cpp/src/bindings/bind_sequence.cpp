#include <mutex>
#include <utility>

#include "arrays.hpp"
#include "common.hpp"
#include "fields.hpp"
#include "lfdcore/primitives/sequence.hpp"
#include "shared.hpp"

namespace lfdcore {
namespace {

using Config = SequenceConfig;

using SharedHmm = Shared<SequenceHmm>;

void bind_config(py::module_& m) {
  bind_settings(m, "SequenceConfig",
                "Transition probabilities (a sample's) and densities of SequenceHmm; none is learned. ValueError "
                "names a field.",
                Field("phase_steps", &Config::phase_steps, "S, states a primitive, 2..1000"),
                Field("pause", &Config::pause, "P(the partner stands still), [0, 1)"),
                Field("finish", &Config::finish, "P(a primitive's last step is left), (0, 1]"),
                Field("chain", &Config::chain, "P(another primitive begins at once | one was left), else none of them"),
                Field("abandon", &Config::abandon, "P(any other step -> none of them), [0, 1)"),
                Field("start", &Config::start, "P(none of them -> the beginning of a primitive), [0, 1]"),
                Field("none_prior", &Config::none_prior, "P(none of them at the first sample), [0, 1)"),
                Field("background_width", &Config::background_width,
                      "none of them is uniform over this many times the demonstrations' range, > 0"),
                Field("widening", &Config::widening, "factor on the demonstrations' variance, > 0"),
                Field("least_deviation", &Config::least_deviation,
                      "least standard deviation, as a share of the demonstrations' range, > 0"));
}

void bind_values(py::module_& m) {
  py::class_<SequencePrimitive>(m, "SequencePrimitive", "A partner's movement over the phase grid s / (S - 1).")
      .def(py::init([](RowMatrix mean, RowMatrix variance, double samples) {
             return SequencePrimitive{std::move(mean), std::move(variance), samples};
           }),
           py::arg("mean"), py::arg("variance"), py::arg("samples"),
           "mean (S, D), variance (S, D) > 0, samples >= 2: duration at tempo 1. Checked by SequenceHmm.")
      .def_readonly("mean", &SequencePrimitive::mean, "(S, D), a view")
      .def_readonly("variance", &SequencePrimitive::variance, "(S, D), a view")
      .def_readonly("samples", &SequencePrimitive::samples);
  py::class_<SequenceBelief>(m, "SequenceBelief", "What the filter knows after a sample.")
      .def_readonly("probabilities", &SequenceBelief::probabilities, "(P,) that the partner is within each; a view")
      .def_readonly("none", &SequenceBelief::none, "that it is in none of them; all sum to 1")
      .def_readonly("steps", &SequenceBelief::steps, "(P, S) joint probabilities of primitive and phase step; a view")
      .def_readonly("progress", &SequenceBelief::progress,
                    "(P,) mean of s / (S - 1) given the primitive, NaN where its probability is 0; a view")
      .def_readonly("recognised", &SequenceBelief::recognised,
                    "the most probable, ties to the first primitive; -1 = none of them")
      .def_readonly("log_likelihood", &SequenceBelief::log_likelihood, "ln p(all samples so far)");
}

py::class_<SharedHmm> bind_learning(py::module_& m) {
  const auto shared = [](SequenceHmm hmm) { return std::make_unique<SharedHmm>(std::move(hmm)); };
  py::class_<SharedHmm> type(
      m, "SequenceHmm",
      "Which task a partner has begun (Sec. 6.2.2): a hidden Markov model, left to right through the phase steps of "
      "each primitive. A sample advances by 0 with probability `pause`, else by a Poisson number of steps, S - 1 in "
      "`samples` samples on average; the last step holds until it is left. Samples are diagonal Gaussians around a "
      "step's mean; in 'none of them' they have a constant density. Forward filter in log space. Positions and their "
      "differences from the sample before, side by side, tell tasks apart sooner than positions.");
  type.def(py::init([=](std::vector<SequencePrimitive> primitives, Eigen::VectorXd background_density,
                        const Config& config) {
             return shared(SequenceHmm(std::move(primitives), std::move(background_density), config));
           }),
           py::arg("primitives"), py::arg("background_density"), py::arg("config") = Config{},
           "background_density (D,) [1 / unit]: of 'none of them' in each dimension. ValueError for no primitives and "
           "for what does not fit or is not finite and positive.")
      .def_static(
          "fit",
          [=](const std::vector<std::vector<RowMatrix>>& demonstrations, const Config& config) {
            const py::gil_scoped_release free;
            return shared(SequenceHmm::fit(demonstrations, config));
          },
          py::arg("demonstrations"), py::arg("config") = Config{},
          "From demonstrations[p], each (T, D) with T >= 2, sampled as the partner will be: stretched to the grid and "
          "once aligned with their mean by DTW; their variance (unbiased, averaged with its mean over the phase) times "
          "`widening`, plus a step's extent, at least `least_deviation` squared. ValueError for none, other shapes and "
          "what is not finite and within 1e100, naming primitive and demonstration.");
  return type;
}

void bind_filter(py::class_<SharedHmm> type) {
  type.def(
          "observe",
          [](SharedHmm& self, const Doubles& sample) {
            const auto at = view(sample);
            const py::gil_scoped_release free;
            const std::lock_guard lock(self.busy);
            return SequenceBelief(self.value.observe(at));
          },
          py::arg("sample"),
          "One step of the forward filter with a sample (D,). NaN in a dimension: not seen, the others count; a sample "
          "without any only lets time pass. ValueError, and it stays as it was, for another D and for what is infinite "
          "or beyond 1e100.")
      .def(
          "reset",
          [](SharedHmm& self) {
            const std::lock_guard lock(self.busy);
            self.value.reset();
          },
          "To the prior, before the first sample.")
      .def_property_readonly("belief", [](SharedHmm& self) {
        const std::lock_guard lock(self.busy);
        return SequenceBelief(self.value.belief());
      });
}

void bind_model(py::class_<SharedHmm> type) {
  type.def(
          "log_advances",
          [](const SharedHmm& self, int primitive) {
            if (primitive < 0 || primitive >= static_cast<int>(self.value.primitives().size()))
              throw py::index_error("there is no primitive " + std::to_string(primitive));
            const auto& log_p = self.value.log_advances(primitive);
            return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(log_p.data(), static_cast<int>(log_p.size())));
          },
          py::arg("primitive"), "(K,) ln P(a sample advances by k = 0, 1, .. steps). IndexError for no such primitive.")
      .def_property_readonly("primitives", [](const SharedHmm& self) { return self.value.primitives(); })
      .def_property_readonly(
          "background_density", [](const SharedHmm& self) { return self.value.background_density(); }, "(D,), a copy")
      .def_property_readonly("config", [](const SharedHmm& self) { return self.value.config(); })
      .def("__len__", [](const SharedHmm& self) { return self.value.primitives().size(); });
}

}  // namespace

void bind_sequence(py::module_& m) {
  bind_config(m);
  bind_values(m);
  const auto hmm = bind_learning(m);
  bind_filter(hmm);
  bind_model(hmm);
}

}  // namespace lfdcore
