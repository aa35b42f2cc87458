#include <cmath>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "arrays.hpp"
#include "common.hpp"
#include "fields.hpp"
#include "lfdcore/error.hpp"
#include "lfdcore/estimation/action_model.hpp"
#include "lfdcore/estimation/belief.hpp"
#include "lfdcore/estimation/belief_update.hpp"
#include "lfdcore/estimation/intention_filter.hpp"
#include "lfdcore/estimation/sparse_subset.hpp"
#include "shared.hpp"

namespace lfdcore {
namespace {

using Indices = py::array_t<std::int64_t, py::array::c_style>;

// Asked for as doubles: as integers, NumPy would cut 1.5 to 1 in silence.
std::vector<std::int64_t> indices_of(const Doubles& given) {
  require(given.ndim() == 1, "the subset has " + std::to_string(given.ndim()) + " dimensions, must be (S,)");
  std::vector<std::int64_t> indices;
  for (const double value : std::span(given.data(), static_cast<std::size_t>(given.size()))) {
    require(std::abs(value) < 9e15 && std::floor(value) == value,
            "the subset names sample " + std::to_string(value) + ", must be integers");
    indices.push_back(static_cast<std::int64_t>(value));
  }
  return indices;
}

Belief belief_of(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance) {
  require(mean.size() <= most_goal_dimensions && covariance.rows() <= most_goal_dimensions &&
              covariance.cols() <= most_goal_dimensions,
          "goals have at most 4 dimensions");
  Belief belief{mean, covariance};
  validate(belief, static_cast<int>(mean.size()));
  return belief;
}

using SharedFilter = Shared<IntentionFilter>;

void bind_kernel(py::module_& m) {
  py::class_<ActionKernel>(m, "ActionKernel",
                           "k((x, g), (x', g')) = a^2 exp(-r^2 / 2) over state and goal (C.5), and the action's noise: "
                           "one action's. H is the squares of the length-scales (ERRATA 3).")
      .def(py::init([](double amplitude, Eigen::VectorXd state_lengthscales, Eigen::VectorXd goal_lengthscales,
                       double noise) {
             ActionKernel kernel{amplitude, std::move(state_lengthscales), std::move(goal_lengthscales), noise};
             validate(kernel);
             return kernel;
           }),
           py::arg("amplitude"), py::arg("state_lengthscales"), py::arg("goal_lengthscales"), py::arg("noise"),
           "amplitude and noise: standard deviations in the action's unit; state_lengthscales (Dx,) in the state's "
           "units; goal_lengthscales (Dg,) [m], at most 4. ValueError unless noise is in [0, 1e20], all others in "
           "[1e-20, 1e20].")
      .def_readonly("amplitude", &ActionKernel::amplitude)
      .def_readonly("state_lengthscales", &ActionKernel::state_lengthscales, "(Dx,), a view")
      .def_readonly("goal_lengthscales", &ActionKernel::goal_lengthscales, "(Dg,) [m], a view")
      .def_readonly("noise", &ActionKernel::noise)
      .def(pickled_by_name(
          Field("amplitude", &ActionKernel::amplitude), Field("state_lengthscales", &ActionKernel::state_lengthscales),
          Field("goal_lengthscales", &ActionKernel::goal_lengthscales), Field("noise", &ActionKernel::noise)));
}

ActionMoments moments_of(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance,
                         const Eigen::MatrixXd& cross_covariance) {
  const Eigen::Index actions = mean.size(), goals = cross_covariance.rows();
  require(actions <= most_actions && goals <= most_goal_dimensions, "at most 4 actions and 4 dimensions of a goal");
  require(covariance.rows() == actions && covariance.cols() == actions && cross_covariance.cols() == actions,
          "mean (Da,), covariance (Da, Da) and cross_covariance (Dg, Da) must fit");
  return {mean, covariance, cross_covariance};
}

void bind_moments(py::module_& m) {
  py::class_<ActionMoments>(m, "ActionMoments", "Joint moments of the action and the goal (Sec. 2.3).")
      .def(py::init(&moments_of), py::arg("mean"), py::arg("covariance"), py::arg("cross_covariance"),
           "ValueError for shapes that do not fit.")
      .def_property_readonly(
          "mean", [](const ActionMoments& s) { return Eigen::VectorXd(s.mean); }, "m (Da,), a copy")
      .def_property_readonly(
          "covariance", [](const ActionMoments& s) { return Eigen::MatrixXd(s.covariance); },
          "G (Da, Da), a copy: of y, so with the noise (ERRATA 2)")
      .def_property_readonly(
          "cross_covariance", [](const ActionMoments& s) { return Eigen::MatrixXd(s.cross_covariance); },
          "C (Dg, Da), a copy: of the goal with y");
}

void bind_belief(py::module_& m) {
  py::class_<Belief>(m, "Belief", "A Gaussian over the goal.")
      .def(py::init(&belief_of), py::arg("mean"), py::arg("covariance"),
           "mean (Dg,) [m], covariance (Dg, Dg) [m^2], may be singular. ValueError unless finite, symmetric and "
           "positive semidefinite (up to 1e-9 of the trace).")
      .def_property_readonly(
          "mean", [](const Belief& b) { return Eigen::VectorXd(b.mean); }, "(Dg,) [m], a copy")
      .def_property_readonly(
          "covariance", [](const Belief& b) { return Eigen::MatrixXd(b.covariance); }, "(Dg, Dg) [m^2], a copy")
      .def(py::pickle(
          [](const Belief& b) { return py::make_tuple(Eigen::VectorXd(b.mean), Eigen::MatrixXd(b.covariance)); },
          [](const py::tuple& t) { return belief_of(t[0].cast<Eigen::VectorXd>(), t[1].cast<Eigen::MatrixXd>()); }))
      .def(
          "widened",
          [](const Belief& self, const Belief& prior, double process_noise) {
            require(self.mean.size() == prior.mean.size(), "belief and prior must have as many dimensions");
            require_between("process_noise", process_noise, 0, largest_number * largest_number, "m^2");
            return widened(self, prior, process_noise);
          },
          py::arg("prior"), py::arg("process_noise"),
          "With process_noise [m^2] more variance along every axis, then cut where that is wider than the prior (not "
          "if the prior is singular). ValueError for a negative process_noise.")
      .def(
          "conditioned",
          [](const Belief& self, const ActionMoments& moments, const Eigen::VectorXd& action) {
            require(action.size() <= most_actions, "an action must have one value for every kernel");
            return conditioned(self, moments, action);
          },
          py::arg("moments"), py::arg("action"),
          "The belief after the action (Da,), whose joint moments with the goal these are (2.2-2.3). ValueError for "
          "other sizes, for what is not finite and if the action's covariance is singular (kernels without noise).");
  m.def(
      "goal_likelihoods",
      [](const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance, const RowMatrix& goals) {
        return goal_likelihoods(belief_of(mean, covariance), goals);
      },
      py::arg("mean"), py::arg("covariance"), py::arg("goals"),
      "Goals (L, Dg) -> (L,) likelihoods that sum to 1: softmax of -d^2 / 2, d the Mahalanobis distance (ERRATA F1). "
      "Standard deviations below 1e-6 of the largest, or 1 nm, count as that: a belief without spread gives all to the "
      "nearest goal. ValueError for no goals and what is not finite.");
}

void bind_model(py::module_& m) {
  py::class_<ActionModel>(
      m, "ActionModel",
      "What a driver does on the way to a goal: Gaussian processes p(y_a | goal, state), conditioned "
      "once (Sec. 2.3, ERRATA 1-4 and 14), then asked as often as wanted, from any thread.")
      .def(py::init([](const RowMatrix& states, const RowMatrix& goals, const RowMatrix& actions,
                       std::vector<ActionKernel> kernels, const std::optional<Doubles>& subset, bool projected) {
             std::vector<std::int64_t> chosen;
             if (subset) chosen = indices_of(*subset);
             const py::gil_scoped_release free;
             return ActionModel(states, goals, actions, std::move(kernels), subset ? &chosen : nullptr, projected);
           }),
           py::arg("states"), py::arg("goals"), py::arg("actions"), py::arg("kernels"), py::arg("subset") = py::none(),
           py::arg("projected") = true,
           "states (N, Dx), goals (N, Dg) [m], actions (N, Da), a kernel for every action. subset (S,) integers: the "
           "samples to use, if projected as the basis of a predictor that keeps all N targets (DTC, ERRATA 14; what "
           "others of the subset span to 1e-10 is left out), else as a smaller training set, as the thesis has it. "
           "Holds 4 N^2 bytes an action, 4 S^2 with a subset. ValueError for data that do not fit or are not finite, "
           "indices out of range or named twice, a covariance that is not positive definite.")
      .def(
          "moments",
          [](const ActionModel& self, const Doubles& state, const Eigen::VectorXd& mean,
             const Eigen::MatrixXd& covariance) {
            const Belief belief = belief_of(mean, covariance);
            const auto at = view(state);
            const py::gil_scoped_release free;
            std::vector<double> scratch(self.scratch_size());
            return self.moments(at, belief, scratch);
          },
          py::arg("state"), py::arg("mean"), py::arg("covariance"),
          "Exact moments at state (Dx,) for a goal ~ N(mean (Dg,), covariance (Dg, Dg)), which may be singular. "
          "ValueError for other sizes and what is not finite.")
      .def_property_readonly("size", &ActionModel::size, "samples asked for: N, or the subset's")
      .def_property_readonly("nbytes", &ActionModel::nbytes, "memory held")
      .def_property_readonly("shared_goals", &ActionModel::shared_goals,
                             "goals that differ, if few enough for sums over pairs of goals in place of pairs of "
                             "samples (about 8 N >= L^2), else 0")
      .def_property_readonly("state_dimensions", &ActionModel::state_dimensions, "Dx")
      .def_property_readonly("goal_dimensions", &ActionModel::goal_dimensions, "Dg")
      .def_property_readonly("actions", &ActionModel::actions, "Da")
      .def_property_readonly("kernels", &ActionModel::kernels)
      .def("__len__", &ActionModel::size);
}

void bind_filter(py::module_& m) {
  py::class_<SharedFilter>(m, "IntentionFilter",
                           "The belief over the driver's goal, updated action by action (2.2-2.3).")
      .def(py::init([](const ActionModel& model, const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance,
                       double process_noise) {
             return std::make_unique<SharedFilter>(IntentionFilter(model, belief_of(mean, covariance), process_noise));
           }),
           py::arg("model"), py::arg("mean"), py::arg("covariance"), py::arg("process_noise") = 0.0,
           "Prior mean (Dg,) [m] and covariance (Dg, Dg) [m^2]; process_noise [m^2] widens the belief before every "
           "update (Belief.widened): 0 is the thesis, whose belief gets overconfident (ERRATA 6). ValueError for "
           "a prior that is none of the model's goals and a negative process_noise.")
      .def(
          "update",
          [](SharedFilter& self, const Doubles& state, const Doubles& action) {
            const auto at = view(state), taken = view(action);
            const py::gil_scoped_release free;
            const std::lock_guard lock(self.busy);
            return Belief(self.value.update(at, taken));
          },
          py::arg("state"), py::arg("action"),
          "The action (Da,) taken at state (Dx,) -> the new belief. ValueError, and the belief stays as it was, for "
          "other sizes, for what is not finite and if the action's covariance is singular (kernels without noise).")
      .def(
          "reset",
          [](SharedFilter& self) {
            const py::gil_scoped_release free;
            const std::lock_guard lock(self.busy);
            self.value.reset();
          },
          "Back to the prior.")
      .def_property_readonly("belief",
                             [](SharedFilter& self) {
                               const py::gil_scoped_release free;
                               const std::lock_guard lock(self.busy);
                               return Belief(self.value.belief());
                             })
      .def_property_readonly("model", [](const SharedFilter& self) { return self.value.model(); })
      .def_property_readonly(
          "process_noise", [](const SharedFilter& self) { return self.value.process_noise(); }, "[m^2]");
}

void bind_subset(py::module_& m) {
  m.def(
      "select_subset",
      [](const RowMatrix& states, const RowMatrix& goals, const RowMatrix& actions,
         const std::vector<ActionKernel>& kernels, int size, int candidates, std::uint64_t seed) {
        std::vector<std::int64_t> selected;
        {
          const py::gil_scoped_release free;
          selected = select_subset(states, goals, actions, kernels, size, candidates, seed);
        }
        return Indices(static_cast<py::ssize_t>(selected.size()), selected.data());
      },
      py::arg("states"), py::arg("goals"), py::arg("actions"), py::arg("kernels"), py::arg("size"),
      py::arg("candidates") = 59, py::arg("seed") = 1,
      "Alg. 1 (ERRATA 11): (size,) int64 indices in the order of selection. In each round, of `candidates` samples "
      "drawn from those left, the one that lowers sum_a Q_a / var(y_a) most; ties to the smallest index; one that the "
      "selected span to 1e-10 gains nothing (ERRATA 13). Needs some 8 N (size + 96) bytes an action. ValueError for a "
      "size that is not in [1, N], candidates < 1, and as ActionModel.");
}

}  // namespace

void bind_action_model(py::module_& m) {
  bind_kernel(m);
  bind_moments(m);
  bind_belief(m);
  bind_model(m);
  bind_filter(m);
  bind_subset(m);
}

}  // namespace lfdcore
