#include "common.hpp"
#include "fields.hpp"
#include "lfdcore/planning/heatmap_reward.hpp"
#include "lfdcore/planning/q_learning.hpp"

namespace lfdcore {
namespace {

using CellTuple = std::pair<int, int>;

Cell as_cell(CellTuple cell) { return {cell.first, cell.second}; }

void bind_heatmap_reward(py::module_& m) {
  bind_settings(m, "HeatmapRewardConfig",
                "Rewards of Sec. 4.5 of blocked cells (obstacle) and of the outermost ring (border).",
                Field("obstacle", &HeatmapRewardConfig::obstacle), Field("border", &HeatmapRewardConfig::border));
  m.def("heatmap_reward", &heatmap_reward, py::arg("heatmap"), py::arg("blocked"),
        py::arg("config") = HeatmapRewardConfig{}, without_gil(),
        "The reward (H, W) float32 of Sec. 4.5: the heatmap (H, W) in [0, 1], the border over it, blocked cells (H, W) "
        "bool (the obstacles grown by what the chair needs) over both. ValueError for an empty heatmap, heat outside "
        "[0, 1] or NaN, or shapes that differ.");
}

void bind_config(py::module_& m) {
  bind_settings(
      m, "QLearningConfig",
      "learning_rate alpha in (0, 1]; discount gamma in (0, 1), .9 in Sec. 4.5, which sees some 10 cells (ERRATA 31, "
      "F9); sweeps 1..100 000 (the printed K = 100 is 99: ERRATA 16); initial_value Q_0 [reward]; blocked: moves into "
      "blocked cells do not exist, else the mask is ignored and obstacles are soft (as printed; ERRATA 20).",
      Field("learning_rate", &QLearningConfig::learning_rate), Field("discount", &QLearningConfig::discount),
      Field("sweeps", &QLearningConfig::sweeps), Field("initial_value", &QLearningConfig::initial_value, "[reward]"),
      Field("blocked", &QLearningConfig::blocked));
}

void bind_result(py::module_& m) {
  py::class_<QLearningResult>(
      m, "QLearningResult",
      "Q after the last sweep, kept as Q(s, a) = q(s'); the methods work it out on demand [reward].")
      .def_readonly("mdp", &QLearningResult::mdp, "as solved: nothing is blocked if the config says so")
      .def_readonly("config", &QLearningResult::config)
      .def_property_readonly(
          "successor_value", [](const QLearningResult& r) -> const GridOf<double>& { return r.successor_value; },
          py::return_value_policy::reference_internal, "q (H, W) [reward], a view; NaN where blocked")
      .def(
          "action_values",
          [](const QLearningResult& r) {
            const ActionValues values = r.action_values();
            return py::array_t<double>({r.mdp.height(), r.mdp.width(), action_count}, values.data());
          },
          "Q (H, W, 9) [reward]; -inf for moves that are not available.")
      .def("greedy_actions", &QLearningResult::greedy_actions, without_gil(),
           "(H, W) int8: argmax_a Q(s, a), ties to the lowest index; -1 where blocked.")
      .def("values", &QLearningResult::values, without_gil(), "max_a Q(s, a) (H, W) [reward]; NaN where blocked.");
  m.def(
      "greedy_path",
      [](const QLearningResult& result, CellTuple start, std::optional<CellTuple> goal) {
        return greedy_path(result, as_cell(start), goal ? std::optional(as_cell(*goal)) : std::nullopt);
      },
      py::arg("result"), py::arg("start_cell"), py::arg("goal_cell") = py::none(), without_gil(),
      "The greedy path (Alg. 3) from a cell (ix, iy), ended by the same rules. Alg. 3 names no goal: without one the "
      "usual end is `stay`, on a local maximum. Where all moves tie, as on an all-zero heatmap, it wanders by the "
      "lowest index: ask whether there is any heat first.");
}

}  // namespace

void bind_q_learning(py::module_& m) {
  bind_heatmap_reward(m);
  bind_config(m);
  bind_result(m);
  py::class_<QLearningSolver>(m, "QLearningSolver",
                              "Q-learning (App. D.1, Alg. 3; Sutton and Barto 1998) on a grid, synchronous. Keeps its "
                              "workspace between grids of one size. Calls from several threads wait for each other.")
      .def(py::init<const QLearningConfig&>(), py::arg("config") = QLearningConfig{})
      .def_property_readonly("config", &QLearningSolver::config)
      .def(
          "solve",
          [](QLearningSolver& solver, const GridMdp& mdp) {
            auto result = std::make_unique<QLearningResult>();
            solver.solve(mdp, *result);
            return result;
          },
          py::arg("mdp"), without_gil(), "Runs the sweeps of D.1 from Q_0.");
}

}  // namespace lfdcore
