#include <mutex>
#include <optional>

#include "common.hpp"
#include "fields.hpp"
#include "lfdcore/primitives/dmp.hpp"
#include "observed.hpp"
#include "shared.hpp"

namespace lfdcore {
namespace {

using OptionalVector = std::optional<Eigen::VectorXd>;

DmpRun run_of(double rate, double phase, OptionalVector position, OptionalVector velocity,
              std::optional<double> duration = {}) {
  return {rate, phase, std::move(position), std::move(velocity), duration};
}

using SharedStepper = Shared<DmpStepper>;

template <auto Get>
auto locked(const SharedStepper& self) {
  const std::lock_guard lock(self.busy);
  return std::decay_t<decltype((self.value.*Get)())>((self.value.*Get)());
}

void bind_config(py::module_& m) {
  bind_settings(m, "DmpConfig",
                "The constants of 5.1 and 5.2 (ERRATA F13): basis_functions M, stiffness alpha_y, damping "
                "beta_y (critical at alpha_y / 4), phase_decay alpha_x. ValueError unless 2 <= M <= 1000, 0 < "
                "alpha_y, beta_y <= 1e4, 0 < alpha_x <= 100.",
                Field("basis_functions", &DmpConfig::basis_functions), Field("stiffness", &DmpConfig::stiffness),
                Field("damping", &DmpConfig::damping), Field("phase_decay", &DmpConfig::phase_decay));
  m.def("phases", &phases, py::arg("steps"), py::arg("config") = DmpConfig{},
        "Phases (steps,) of samples evenly spread over a demonstration: exp(-alpha_x k / (steps - 1)). ValueError "
        "unless 2 <= steps <= 1e6.");
  m.def("basis", &basis, py::arg("phase"), py::arg("config") = DmpConfig{}, without_gil(),
        "phi(x)^T of 5.2 at phases (T,), the factor x included -> (T, M). ValueError for a phase outside (0, 1].");
  m.def("forcing_terms", &forcing_terms, py::arg("positions"), py::arg("goal"), py::arg("config") = DmpConfig{},
        without_gil(),
        "5.3 for positions (T, D), T >= 3, at normalised times k / (T - 1), and the goal (D,) -> (T, D); derivatives "
        "as np.gradient(edge_order=2). ValueError for other shapes and values not finite or beyond 1e9.");
}

void bind_trajectory(py::module_& m) {
  py::class_<DmpTrajectory>(m, "DmpTrajectory",
                            "A motion of D degrees of freedom; its arrays are views, one degree of freedom contiguous.")
      .def_readonly("time", &DmpTrajectory::time, "(steps,) [s] since the begin")
      .def_readonly("positions", &DmpTrajectory::positions, "(steps, D)")
      .def_readonly("velocities", &DmpTrajectory::velocities, "(steps, D) a second")
      .def_readonly("accelerations", &DmpTrajectory::accelerations, "(steps, D) a second squared");
}

void bind_stepper(py::module_& m) {
  py::class_<SharedStepper>(m, "DmpStepper", "A motion that is run step by step (Dmp.begin).")
      .def(
          "step",
          [](SharedStepper& self, double dt) {
            const std::lock_guard lock(self.busy);
            self.value.step(dt);
            return Eigen::VectorXd(self.value.position());
          },
          py::arg("dt"), without_gil(),
          "Advances by dt >= 0 [s], exact up to 1e-9 of the range whatever dt is -> position (D,). ValueError for dt * "
          "rate > 1e4 or not finite.")
      .def_property_readonly("position", &locked<&DmpStepper::position>, "(D,), a copy")
      .def_property_readonly("velocity", &locked<&DmpStepper::velocity>, "(D,) a second, a copy")
      .def_property_readonly("phase", &locked<&DmpStepper::phase>, "x; below exp(-alpha_x) the motion is over")
      .def_property(
          "goal", &locked<&DmpStepper::goal>,
          [](SharedStepper& self, const Eigen::VectorXd& goal) {
            const std::lock_guard lock(self.busy);
            self.value.set_goal(goal);
          },
          "(D,); may be set on the run, position and velocity stay continuous. ValueError unless finite.")
      .def_property(
          "rate", &locked<&DmpStepper::rate>,
          [](SharedStepper& self, double rate) {
            const std::lock_guard lock(self.busy);
            self.value.set_rate(rate);
          },
          "tau [1/s]; may be set on the run, position and velocity stay continuous. ValueError unless > 0.");
}

}  // namespace

void bind_dmp(py::module_& m) {
  bind_config(m);
  bind_trajectory(m);
  bind_stepper(m);
  const auto defaults = DmpRun{};
  py::class_<Dmp>(m, "Dmp",
                  "A dynamic movement primitive of D degrees of freedom (5.1-5.4): y'' = (alpha_y (beta_y (g - y) - y' "
                  "/ tau) + phi(x)^T w) tau^2, x' = -alpha_x x tau. tau is a rate, 1 / duration (ERRATA 34).")
      .def(py::init<Eigen::VectorXd, Eigen::VectorXd, RowMatrix, const DmpConfig&>(), py::arg("start"), py::arg("goal"),
           py::arg("weights"), py::arg("config") = DmpConfig{},
           "start (D,), goal (D,), weights (D, M). ValueError for other shapes and what is not finite.")
      .def_static(
          "fit",
          [](const RowMatrix& positions, const DmpConfig& config, const std::string& by) {
            return Dmp::fit(positions, config, observed_of("by", by));
          },
          py::arg("positions"), py::arg("config") = DmpConfig{}, py::kw_only(),
          py::arg("by") = name_of(Observed::forcing), without_gil(),
          "Positions (T, D), T >= 3, evenly spaced in time; the demonstration's duration does not matter, a run's rate "
          "gives it back. by='forcing': least squares of 5.3 with differences as derivatives, the goal is the last "
          "position (5.4, ERRATA 37). by='positions': start, goal and weights are least squares of the motion from "
          "rest itself, without derivatives, which noise spoils. ValueError for fewer samples and values not finite or "
          "beyond 1e9.")
      .def(
          "rollout",
          [](const Dmp& self, int steps, double rate, double phase, OptionalVector position, OptionalVector velocity,
             std::optional<double> duration) {
            return self.rollout(steps, run_of(rate, phase, std::move(position), std::move(velocity), duration));
          },
          py::arg("steps"), py::kw_only(), py::arg("rate") = defaults.rate, py::arg("phase") = defaults.phase,
          py::arg("position") = py::none(), py::arg("velocity") = py::none(), py::arg("duration") = py::none(),
          without_gil(),
          "The motion in `steps` evenly spread samples, exact up to 1e-9 of its range. rate tau [1/s]; phase in (0, 1] "
          "at the begin; position (D,) there, by default the start; velocity (D,) a second, by default at rest; "
          "duration [s], by default up to the demonstration's end. The matrix that maps (w, g, position, velocity) to "
          "the samples is kept for the next call with the same steps, phase and duration * rate. ValueError unless "
          "steps in [2, 1e6], rate > 0 and all finite, and for a phase at the end without a duration.")
      .def(
          "begin",
          [](const Dmp& self, double rate, double phase, OptionalVector position, OptionalVector velocity) {
            return std::make_unique<SharedStepper>(
                self.begin(run_of(rate, phase, std::move(position), std::move(velocity))));
          },
          py::kw_only(), py::arg("rate") = defaults.rate, py::arg("phase") = defaults.phase,
          py::arg("position") = py::none(), py::arg("velocity") = py::none(),
          "A DmpStepper from anywhere: phase in (0, 1], position (D,), velocity (D,) a second; else as rollout.")
      .def_property_readonly("start", &Dmp::start, "(D,), a view")
      .def_property_readonly("goal", &Dmp::goal, "(D,), a view")
      .def_property_readonly("weights", &Dmp::weights, "(D, M), a view")
      .def_property_readonly("config", &Dmp::config)
      .def_property_readonly("dimensions", &Dmp::dimensions, "D")
      .def(py::pickle([](const Dmp& d) { return py::make_tuple(d.start(), d.goal(), d.weights(), d.config()); },
                      [](const py::tuple& t) {
                        return Dmp(t[0].cast<Eigen::VectorXd>(), t[1].cast<Eigen::VectorXd>(), t[2].cast<RowMatrix>(),
                                   t[3].cast<DmpConfig>());
                      }));
}

}  // namespace lfdcore
