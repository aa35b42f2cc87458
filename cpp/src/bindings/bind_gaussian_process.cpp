#include <pybind11/functional.h>

#include <limits>
#include <mutex>

#include "arrays.hpp"
#include "common.hpp"
#include "fields.hpp"
#include "lfdcore/error.hpp"
#include "lfdcore/estimation/differential_evolution.hpp"
#include "lfdcore/estimation/gaussian_process.hpp"
#include "lfdcore/estimation/gaussian_process_likelihood.hpp"
#include "lfdcore/estimation/kernel.hpp"
#include "shared.hpp"

namespace lfdcore {
namespace {

constexpr std::array families{std::pair{"squared_exponential", KernelFamily::squared_exponential},
                              std::pair{"matern_3_2", KernelFamily::matern_3_2},
                              std::pair{"matern_5_2", KernelFamily::matern_5_2}};

KernelFamily family_of(const std::string& name) {
  for (const auto& [known, family] : families)
    if (name == known) return family;
  throw std::invalid_argument("family is '" + name + "', must be squared_exponential, matern_3_2 or matern_5_2");
}

std::string name_of(KernelFamily family) {
  for (const auto& [name, known] : families)
    if (family == known) return name;
  return "";
}

}  // namespace

template <>
struct Seen<KernelFamily> {
  using Type = std::string;
  static std::string to_python(KernelFamily family) { return name_of(family); }
  static KernelFamily from_python(const char*, const std::string& name) { return family_of(name); }
};

namespace {

using SharedLikelihood = Shared<GaussianProcessLikelihood>;

void bind_kernel(py::module_& m) {
  py::class_<Kernel>(m, "Kernel",
                     "A stationary covariance function with a length-scale for every input dimension, over r^2 = sum "
                     "((x_d - x'_d) / l_d)^2: 'squared_exponential' (C.5), 'matern_3_2' or 'matern_5_2' (C.6).")
      .def(py::init([](double amplitude, Eigen::VectorXd lengthscales, const std::string& family) {
             Kernel kernel{family_of(family), amplitude, std::move(lengthscales)};
             validate(kernel);
             return kernel;
           }),
           py::arg("amplitude"), py::arg("lengthscales"), py::kw_only(), py::arg("family") = "squared_exponential",
           "amplitude: standard deviation of f, in the targets' unit; lengthscales (D,), in the inputs' units. "
           "ValueError unless all are > 0 and finite.")
      .def_readonly("amplitude", &Kernel::amplitude)
      .def_readonly("lengthscales", &Kernel::lengthscales, "(D,), a view")
      .def_property_readonly("family", [](const Kernel& k) { return name_of(k.family); })
      .def("covariance", &covariance, py::arg("a"), py::arg("b"), without_gil(),
           "Inputs (N, D), (M, D) -> (N, M). ValueError for another D.")
      .def(pickled_by_name(Field("family", &Kernel::family), Field("amplitude", &Kernel::amplitude),
                           Field("lengthscales", &Kernel::lengthscales)));
}

void bind_regression(py::module_& m) {
  py::class_<GaussianMoments>(m, "GaussianMoments", "mean (M,) and variance (M,) of M Gaussians.")
      .def_readonly("mean", &GaussianMoments::mean, "(M,), a view")
      .def_readonly("variance", &GaussianMoments::variance, "(M,) >= 0, a view");
  py::class_<GaussianProcess>(
      m, "GaussianProcess",
      "y_n = f(x_n) + e_n, f ~ GP(0, kernel), e_n ~ N(0, noise_variances[n] + noise^2): conditioned once (App. C.3, "
      "ERRATA 33), then asked as often as wanted, from any thread.")
      .def(py::init<const RowMatrix&, const Eigen::VectorXd&, const Eigen::VectorXd&, Kernel, double>(),
           py::arg("inputs"), py::arg("targets"), py::arg("noise_variances"), py::arg("kernel"), py::arg("noise"),
           without_gil(),
           "inputs (N, D), targets (N,), noise_variances (N,) the samples' own, noise a standard deviation. ValueError "
           "for data or parameters that do not fit, and if the covariance is not positive definite.")
      .def("predict", py::overload_cast<const RowMatrix&, bool>(&GaussianProcess::predict, py::const_),
           py::arg("queries"), py::arg("with_noise") = false, without_gil(),
           "Queries (M, D) -> mean and variance of f there (C.4), with_noise of y (noise^2 added). A query with NaN or "
           "inf gives NaN. ValueError for another D.")
      .def(
          "predict_one",
          [](const GaussianProcess& gp, const Doubles& query) {
            std::vector<double> scratch(gp.scratch_size());
            std::pair<double, double> moments;
            gp.predict(view(query), scratch, moments.first, moments.second);
            return moments;
          },
          py::arg("query"), "One query (D,) -> (mean, variance) of f: `predict` with less overhead.")
      .def_property_readonly("log_likelihood", &GaussianProcess::log_likelihood, "C.3 of the data conditioned on")
      .def_property_readonly("kernel", &GaussianProcess::kernel)
      .def_property_readonly("noise", &GaussianProcess::noise)
      .def_property_readonly("dimensions", &GaussianProcess::dimensions, "D")
      .def("__len__", &GaussianProcess::size);
}

void bind_likelihood(py::module_& m) {
  constexpr double nothing = -std::numeric_limits<double>::infinity();
  py::class_<SharedLikelihood>(m, "GaussianProcessLikelihood",
                               "log p(Y | X) as a function of (log amplitude, log l_1 .. log l_D, log noise) (C.3).")
      .def(py::init([](const RowMatrix& inputs, const Eigen::VectorXd& targets, const Eigen::VectorXd& noise_variances,
                       const std::string& family) {
             return std::make_unique<SharedLikelihood>(
                 GaussianProcessLikelihood(inputs, targets, noise_variances, family_of(family)));
           }),
           py::arg("inputs"), py::arg("targets"), py::arg("noise_variances"), py::kw_only(),
           py::arg("family") = "squared_exponential",
           "inputs (N, D), targets (N,), noise_variances (N,). ValueError for data that do not fit or are not finite.")
      .def(
          "evaluate",
          [](SharedLikelihood& self, const Doubles& log_parameters, double give_up_below) {
            const auto at = view(log_parameters);
            py::gil_scoped_release free;
            const std::lock_guard lock(self.busy);
            return self.value.evaluate(at, give_up_below);
          },
          py::arg("log_parameters"), py::arg("give_up_below") = nothing,
          "log_parameters (D + 2,) -> log p(Y | X) with K + diag(noise_variances + noise^2) (ERRATA 33); -inf where "
          "that is not positive definite, and early where the result is certain to be below give_up_below.")
      .def(
          "evaluate_with_gradient",
          [](SharedLikelihood& self, const Doubles& log_parameters) {
            const auto at = view(log_parameters);
            Eigen::VectorXd derivatives(static_cast<Eigen::Index>(at.size()));
            double value = 0;
            {
              py::gil_scoped_release free;
              const std::lock_guard lock(self.busy);
              value = self.value.evaluate_with_gradient(at, {derivatives.data(), at.size()});
            }
            return std::pair(value, derivatives);
          },
          py::arg("log_parameters"), "-> log p(Y | X), its derivatives (D + 2,); NaN where the likelihood is -inf.")
      .def(
          "maximise",
          [](SharedLikelihood& self, const RowMatrix& bounds, const DifferentialEvolutionConfig& config) {
            py::gil_scoped_release free;
            const std::lock_guard lock(self.busy);
            return maximise_likelihood(self.value, bounds, config);
          },
          py::arg("bounds"), py::arg("config") = DifferentialEvolutionConfig{},
          "Differential evolution over bounds (D + 2, 2) of the log parameters; the result's value is the likelihood.")
      .def_property_readonly(
          "dimensions", [](const SharedLikelihood& s) { return s.value.dimensions(); }, "D")
      .def("__len__", [](const SharedLikelihood& s) { return s.value.size(); });
}

void bind_evolution(py::module_& m) {
  using Config = DifferentialEvolutionConfig;
  bind_settings(m, "DifferentialEvolutionConfig",
                "best/1/bin with dither, as SciPy's defaults: population: members for every parameter; "
                "generations: at most; recombination: probability of the mutant's parameter; mutation_low, "
                "mutation_high: range of the difference's weight; done once the values' standard deviation is "
                "<= absolute_tolerance + tolerance |mean|; seed.",
                Field("population", &Config::population), Field("generations", &Config::generations),
                Field("recombination", &Config::recombination), Field("mutation_low", &Config::mutation_low),
                Field("mutation_high", &Config::mutation_high), Field("tolerance", &Config::tolerance),
                Field("absolute_tolerance", &Config::absolute_tolerance), Field("seed", &Config::seed));
  using Result = DifferentialEvolutionResult;
  py::class_<Result>(m, "DifferentialEvolutionResult",
                     "best (D,), its value, generations, evaluations; converged is False if the generations ran out.")
      .def_readonly("best", &Result::best, "(D,), a view")
      .def_readonly("value", &Result::value)
      .def_readonly("generations", &Result::generations)
      .def_readonly("evaluations", &Result::evaluations)
      .def_readonly("converged", &Result::converged);
  m.def(
      "differential_evolution",
      [](const std::function<double(Eigen::VectorXd)>& objective, const RowMatrix& bounds, const Config& config) {
        const auto call = [&](std::span<const double> x, double) {
          try {
            return objective(Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size())));
          } catch (const py::cast_error&) {
            throw std::invalid_argument("objective gave something that is no number");
          }
        };
        return differential_evolution(call, bounds, config);
      },
      py::arg("objective"), py::arg("bounds"), py::arg("config") = Config{},
      "Minimises objective((D,)) -> float in the box of bounds (D, 2); NaN counts as +inf. The same seed gives the "
      "same result. ValueError for bounds that are not finite or not low < high.");
}

}  // namespace

void bind_gaussian_process(py::module_& m) {
  bind_kernel(m);
  bind_evolution(m);
  bind_regression(m);
  bind_likelihood(m);
}

}  // namespace lfdcore
