#include <algorithm>
#include <mutex>
#include <optional>

#include "common.hpp"
#include "lfdcore/primitives/interaction_primitive.hpp"
#include "observed.hpp"
#include "shared.hpp"

namespace lfdcore {
namespace {

using Config = InteractionPrimitiveConfig;
using OptionalVector = std::optional<Eigen::VectorXd>;
using OptionalSeries = std::optional<RowMatrix>;

using SharedObserver = Shared<InteractionObserver>;

// (A, B, C) of what lies row after row in `values`, which `owner` keeps alive.
py::array cube(const double* values, Eigen::Index a, Eigen::Index b, Eigen::Index c, py::handle owner) {
  return py::array_t<double>({a, b, c}, values, owner);
}

py::array stacked(const std::vector<RowMatrix>& motions, Eigen::Index steps, Eigen::Index dimensions) {
  py::array_t<double> all({static_cast<Eigen::Index>(motions.size()), steps, dimensions});
  double* at = all.mutable_data();
  for (const RowMatrix& motion : motions) at = std::copy_n(motion.data(), motion.size(), at);
  return all;
}

void bind_config(py::module_& m) {
  bind_settings(
      m, "InteractionPrimitiveConfig",
      "observe: what enters the likelihood, and by what demonstrations are fitted: 'forcing' (5.11) or 'positions', "
      "which needs no derivatives. noise: sigma^2, a variance in the unit of what is observed (ERRATA 41), by default "
      "the partner's squared residual after the fit, pooled over samples, dimensions and demonstrations (ERRATA F13). "
      "environment_noise: sigma_e^2 of the standardised environment. printed_environment_weights: the environment as "
      "w_e theta as printed after 5.16, instead of jointly Gaussian with theta (ERRATA 42). ValueError unless the "
      "variances are > 0.",
      Field("dmp", &Config::dmp), Field("observe", &Config::observe), Field("noise", &Config::noise),
      Field("environment_noise", &Config::environment_noise),
      Field("printed_environment_weights", &Config::printed_environment_weights));
}

void bind_posterior(py::module_& m) {
  using Trajectory = InteractionTrajectory;
  py::class_<Trajectory>(m, "InteractionTrajectory",
                         "N degrees of freedom, the partner's first, at evenly spread samples of the motion.")
      .def_readonly("mean", &Trajectory::mean, "(steps, N), a view")
      .def_property_readonly(
          "covariance",
          [](const py::object& self) {
            const auto& made = self.cast<const Trajectory&>();
            return cube(made.covariance.data(), made.mean.rows(), made.mean.cols(), made.mean.cols(), self);
          },
          "(steps, N, N), a view: between the degrees of freedom at one time");
  using Posterior = InteractionPosterior;
  py::class_<Posterior>(m, "InteractionPosterior",
                        "p(theta | what was seen) = N(mean, factor factor^T) (5.15); rank < S.")
      .def_property_readonly("mean", &Posterior::mean, "(D,), D = N (M + 1): w_1, g_1, w_2, ...; computed anew")
      .def_property_readonly("factor", &Posterior::factor, "(D, S), the covariance is factor @ factor.T; computed anew")
      .def_property_readonly("start", &Posterior::start, "(N,) expected begin of the motion")
      .def_property_readonly("log_likelihood", &Posterior::log_likelihood,
                             "ln p(what was seen), the environment standardised (first block of 5.14)")
      .def_property_readonly("trace", &Posterior::trace, "of theta's covariance")
      .def_property_readonly("robot", &Posterior::robot,
                             "The mean's Dmp of the robot, to be run from phase x* and the robot's own state (ERRATA "
                             "F14). ValueError if the primitive has no robot.")
      .def_property_readonly("partner", &Posterior::partner, "The mean's Dmp of the partner")
      .def("trajectory", &Posterior::trajectory, py::arg("steps"), without_gil(),
           "Mean and covariance of the motion, linear in theta and its start. ValueError unless 2 <= steps <= 1e6.")
      .def("sample", &Posterior::sample, py::arg("count"), py::arg("seed"), without_gil(),
           "theta (count, D); the same seed gives the same.")
      .def(
          "sample_trajectories",
          [](const Posterior& self, int count, int steps, std::uint64_t seed) {
            std::vector<RowMatrix> motions;
            {
              const py::gil_scoped_release free;
              motions = self.sample_trajectories(count, steps, seed);
            }
            return stacked(motions, steps, motions.front().cols());
          },
          py::arg("count"), py::arg("steps"), py::arg("seed"),
          "Motions (count, steps, N) of the same draws as sample(count, seed).");
}

void bind_observer(py::module_& m) {
  py::class_<SharedObserver>(m, "InteractionObserver",
                             "Gathers what is seen, sample by sample (InteractionPrimitive.begin).")
      .def(
          "observe",
          [](SharedObserver& self, double phase, const Eigen::VectorXd& values) {
            const std::lock_guard lock(self.busy);
            self.value.observe(phase, values);
          },
          py::arg("phase"), py::arg("values"), without_gil(),
          "The partner's forcing (n,), as partner_forcing gives it, or positions (n,), as the config says, at a phase "
          "in [exp(-alpha_x), 1]; NaN where not seen. In any order. ValueError for other shapes and infinity.")
      .def(
          "posterior",
          [](SharedObserver& self) {
            const std::lock_guard lock(self.busy);
            return self.value.posterior();
          },
          without_gil(), "The same as condition() gives for all that was observed.");
}

}  // namespace

void bind_interaction_primitive(py::module_& m) {
  bind_config(m);
  bind_posterior(m);
  bind_observer(m);
  using Primitive = InteractionPrimitive;
  py::class_<Primitive>(
      m, "InteractionPrimitive",
      "A Gaussian over the parameters of S demonstrations of partner and robot (5.6-5.9), and of the environment "
      "(5.16-5.19), conditioned on what is seen (5.15 in its S x S form, ERRATA 40).")
      .def(py::init<const RowMatrix&, const RowMatrix&, const OptionalSeries&, int, const Config&>(),
           py::arg("parameters"), py::arg("starts"), py::arg("environment"), py::arg("partner_dimensions"),
           py::arg("config"),
           "From another primitive's attributes of the same names, with the same answers. parameters (S, N (M + 1)), "
           "starts (S, N), environment (S, E) or None, config.noise set. ValueError for shapes that do not fit, what "
           "is not finite and an environment column that does not vary.")
      .def_static("fit", &Primitive::fit, py::arg("partner"), py::arg("robot"), py::arg("environment") = py::none(),
                  py::arg("config") = Config{}, without_gil(),
                  "S >= 2 demonstrations: partner, robot: lists of (T_j, n) and (T_j, r), evenly spaced in time, each "
                  "fitted in its own normalised time, so that lengths may differ; environment (S, E), any units: it is "
                  "standardised. ValueError as Dmp.fit, for different dimensions or counts, and for an environment "
                  "column that does not vary.")
      .def(
          "condition",
          [](const Primitive& self, const OptionalSeries& partner, const OptionalVector& phase,
             const OptionalVector& environment) {
            const RowMatrix none(0, self.partner_dimensions());
            return self.condition(partner ? *partner : none, phase ? *phase : Eigen::VectorXd(), environment);
          },
          py::arg("partner") = py::none(), py::arg("phase") = py::none(), py::arg("environment") = py::none(),
          without_gil(),
          "Partner's positions (K, n) at falling phases (K,), environment (E,). NaN: not seen; nothing seen gives the "
          "prior. With observe='forcing', fewer than 3 seen samples in a row are left out. Phases are in "
          "[exp(-alpha_x), 1]: an observation longer than the motion is refused. ValueError for other shapes, phases "
          "and values beyond 1e9.")
      .def(
          "begin",
          [](const Primitive& self, const OptionalVector& environment) {
            return std::make_unique<SharedObserver>(self.begin(environment));
          },
          py::arg("environment") = py::none(), "An InteractionObserver, for an observation that grows.")
      .def_property_readonly("parameters", &Primitive::parameters, "(S, D), a view")
      .def_property_readonly("starts", &Primitive::starts, "(S, N), a view")
      .def_property_readonly("environment", &Primitive::environment, "(S, E) as given, or None")
      .def_property_readonly("partner_dimensions", &Primitive::partner_dimensions, "n")
      .def_property_readonly("robot_dimensions", &Primitive::robot_dimensions, "r")
      .def_property_readonly("config", &Primitive::config, "with the noise in use")
      .def(py::pickle(
          [](const Primitive& p) {
            return py::make_tuple(p.parameters(), p.starts(), p.environment(), p.partner_dimensions(), p.config());
          },
          [](const py::tuple& t) {
            return Primitive(t[0].cast<RowMatrix>(), t[1].cast<RowMatrix>(), t[2].cast<OptionalSeries>(),
                             t[3].cast<int>(), t[4].cast<Config>());
          }));
  m.def("partner_forcing", &partner_forcing, py::arg("positions"), py::arg("phase"), py::arg("config") = DmpConfig{},
        without_gil(),
        "F of 5.12 of a partner's positions (K, n) at falling phases (K,); NaN where fewer than 3 samples in a row "
        "were seen. ValueError as for condition().");
}

}  // namespace lfdcore
