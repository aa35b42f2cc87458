#include "arrays.hpp"
#include "common.hpp"
#include "fields.hpp"
#include "lfdcore/error.hpp"
#include "lfdcore/planning/dpp.hpp"

namespace lfdcore {
namespace {

using CellTuple = std::pair<int, int>;

Cell as_cell(CellTuple cell) { return {cell.first, cell.second}; }

CellPath as_cells(const py::array& cells) {
  const bool whole = cells.dtype().kind() == 'i' || cells.dtype().kind() == 'u';
  require(whole && cells.ndim() == 2 && cells.shape(1) == 2, "path_cells must be an (N, 2) array of integers [ix, iy]");
  const auto given = cells.cast<Eigen::Matrix<std::int64_t, Eigen::Dynamic, 2, Eigen::RowMajor>>();
  require((given.array() == given.cast<int>().cast<std::int64_t>().array()).all(),
          "path_cells holds a number beyond 32 bits, so no cell of a grid");
  return given.cast<int>();
}

Preferences as_preferences(const Doubles& given, const GridMdp& mdp) {
  const bool fits = given.ndim() == 3 && given.shape(0) == mdp.height() && given.shape(1) == mdp.width() &&
                    given.shape(2) == action_count;
  require(fits, "initial_preference must be a (" + std::to_string(mdp.height()) + ", " + std::to_string(mdp.width()) +
                    ", 9) array (height, width, action)");
  return Eigen::Map<const Preferences>(given.data(), mdp.reward.size(), action_count);
}

py::array_t<double> as_array(const Preferences& preferences, int height, int width) {
  return py::array_t<double>({height, width, action_count}, preferences.data());
}

void bind_grid_mdp(py::module_& m) {
  py::class_<GridMdp>(m, "GridMdp",
                      "The grid world as a Markov decision process (App. D.2): a state a cell, 9 deterministic moves, "
                      "row-major over (dy, dx) in (-1, 0, 1)^2 with 4 = stay; a move out of the grid stays. Rewards "
                      "(H, W) are gained on arrival. No move enters a blocked (H, W) cell or passes diagonally between "
                      "two. ValueError for shapes that differ, an empty grid or a reward that is not finite.")
      .def(py::init<FloatGrid, Mask>(), py::arg("reward"), py::arg("blocked"))
      .def(py::init<FloatGrid>(), py::arg("reward"))
      .def_property_readonly(
          "reward", [](const GridMdp& mdp) -> const FloatGrid& { return mdp.reward; },
          py::return_value_policy::reference_internal, "(H, W) float32, a view")
      .def_property_readonly(
          "blocked", [](const GridMdp& mdp) -> const Mask& { return mdp.blocked; },
          py::return_value_policy::reference_internal, "(H, W) bool, a view")
      .def(py::pickle([](const GridMdp& mdp) { return py::make_tuple(mdp.reward, mdp.blocked); },
                      [](const py::tuple& t) { return GridMdp(t[0].cast<FloatGrid>(), t[1].cast<Mask>()); }));
}

void bind_path_reward(py::module_& m) {
  bind_settings(m, "RewardConfig",
                "Rewards of Sec. 3.5: obstacle and border (the outermost ring of cells), spread by a Gaussian "
                "of blur_sigma [cells] cut off at 4 sigma; path_first .. path_last linearly along the path.",
                Field("obstacle", &RewardConfig::obstacle), Field("border", &RewardConfig::border),
                Field("blur_sigma", &RewardConfig::blur_sigma, "[cells]"),
                Field("path_first", &RewardConfig::path_first), Field("path_last", &RewardConfig::path_last));
  m.def(
      "path_cells", [](const Path& path, const OccupancyGrid& grid) { return path_cells(path, grid.geometry); },
      py::arg("path"), py::arg("grid"),
      "The cells (N, 2) [ix, iy] that a polyline (M, 2) [m, frame of the grid] passes: consecutive ones differ and "
      "touch at a side or a corner. Cells outside the grid are left out. ValueError for points that are not finite or "
      "more than 100 000 cells off.");
  m.def(
      "path_reward",
      [](const Mask& occupied, const py::array& cells, const RewardConfig& reward_config) {
        return path_reward(occupied, as_cells(cells), reward_config);
      },
      py::arg("occupied"), py::arg("path_cells"), py::arg("config") = RewardConfig{},
      "The reward (H, W) float32 of Sec. 3.5 for occupied cells (H, W) bool and path cells (N, 2) [ix, iy]: obstacles "
      "and border blurred, the path over that, obstacles and border over the path (ERRATA 21). A cell that the path "
      "visits twice keeps its later reward. ValueError for an empty grid or a path cell outside it.");
}

void bind_greedy_path(py::module_& m) {
  py::enum_<PathOutcome>(m, "PathOutcome", "Why a greedy path ended (ERRATA 15).")
      .value("goal", PathOutcome::goal, "in the goal cell")
      .value("stay", PathOutcome::stay, "the best move is to stay, short of the goal")
      .value("cycle", PathOutcome::cycle, "the next cell had been visited")
      .value("start_blocked", PathOutcome::start_blocked, "the start is a blocked cell: there is no move");
  py::class_<GreedyPath>(m, "GreedyPath", "A path over cells and why it ended.")
      .def_readonly("cells", &GreedyPath::cells,
                    "(N, 2) [ix, iy] from the start (included) to the last cell reached; no cell twice")
      .def_readonly("outcome", &GreedyPath::outcome)
      .def_property_readonly(
          "reached_goal", [](const GreedyPath& path) { return path.outcome == PathOutcome::goal; },
          "whether it ended in the goal cell");
  m.def(
      "greedy_path",
      [](const DppResult& result, CellTuple start, CellTuple goal) {
        return greedy_path(result, as_cell(start), as_cell(goal));
      },
      py::arg("result"), py::arg("start_cell"), py::arg("goal_cell"), without_gil(),
      "The greedy path (Alg. 2) between cells (ix, iy); it ends in the goal cell, where the best move is to stay, or "
      "before a cell visited already (ERRATA 15). ValueError for a cell outside the grid.");
}

void bind_config(py::module_& m) {
  bind_settings(m, "DppConfig",
                "discount gamma in (0, 1); inverse_temperature eta [1/reward] > 0; sweeps 1..100 000 (Sec. 3.5 "
                "prints K = 100, which is 99 sweeps: ERRATA 16); blocked: moves into blocked cells do not "
                "exist, else the mask is ignored and obstacles are soft (ERRATA 20).",
                Field("discount", &DppConfig::discount),
                Field("inverse_temperature", &DppConfig::inverse_temperature, "[1/reward]"),
                Field("sweeps", &DppConfig::sweeps), Field("blocked", &DppConfig::blocked));
}

void bind_result(py::module_& m) {
  py::class_<DppResult>(m, "DppResult",
                        "Action preferences after the last sweep, kept as Psi(s, a) = Psi_0(s, a) + A(s') - B(s); the "
                        "methods work them out on demand [reward].")
      .def_readonly("mdp", &DppResult::mdp, "as solved: nothing is blocked if the config says so")
      .def_readonly("config", &DppResult::config)
      .def_property_readonly(
          "successor_part", [](const DppResult& r) -> const DoubleGrid& { return r.successor_part; },
          py::return_value_policy::reference_internal, "A (H, W) [reward], a view; NaN where blocked")
      .def_property_readonly(
          "state_part", [](const DppResult& r) -> const DoubleGrid& { return r.state_part; },
          py::return_value_policy::reference_internal, "B (H, W) [reward], a view; NaN where blocked")
      .def(
          "preferences", [](const DppResult& r) { return as_array(r.preferences(), r.mdp.height(), r.mdp.width()); },
          "Psi (H, W, 9) [reward]; -inf for moves that are not available.")
      .def("greedy_actions", &DppResult::greedy_actions, without_gil(),
           "(H, W) int8: argmax_a Psi(s, a), ties to the lowest index; -1 where blocked.")
      .def("values", &DppResult::values, without_gil(),
           "M_eta Psi (H, W), the Boltzmann mean of D.8 [reward]; NaN where blocked.");
}

void bind_solver(py::module_& m) {
  m.def(
      "baseline_preference",
      [](const py::array& cells, CellTuple shape, double probability, double inverse_temperature) {
        const auto [height, width] = shape;
        return as_array(baseline_preference(as_cells(cells), height, width, probability, inverse_temperature), height,
                        width);
      },
      py::arg("path_cells"), py::arg("shape"), py::arg("probability") = 0.9,
      py::arg("inverse_temperature") = DppConfig{}.inverse_temperature,
      "Psi_0 (H, W, 9) = (log pi_0 + entropy(pi_0)) / eta of a baseline that follows path cells (N, 2) [ix, iy] "
      "(ERRATA 19): `probability` on the path's move (to stay on its last cell), the rest shared by the other 8; "
      "uniform, so 0, off the path. ValueError unless 0 < probability < 1, consecutive cells are neighbours, there are "
      "at most 10 000 000 cells and the preferences are finite.");
  py::class_<DppSolver>(
      m, "DppSolver",
      "Dynamic policy programming (App. D.2, Alg. 2; Azar et al. 2012) on a grid. Keeps its workspace "
      "between grids of one size. Calls from several threads wait for each other.")
      .def(py::init<const DppConfig&>(), py::arg("config") = DppConfig{})
      .def_property_readonly("config", &DppSolver::config)
      .def(
          "solve",
          [](DppSolver& solver, const GridMdp& mdp, const std::optional<py::array>& initial) {
            const Preferences start = initial ? as_preferences(*initial, mdp) : Preferences(0, action_count);
            const py::gil_scoped_release released;
            auto result = std::make_unique<DppResult>();
            solver.solve(mdp, start, *result);
            return result;
          },
          py::arg("mdp"), py::arg("initial_preference") = py::none(),
          "Runs the sweeps of D.7 from Psi_0 = 0 or a given (H, W, 9) initial preference [reward]. ValueError if "
          "rewards are too large against the temperature (exponents beyond 1e9).");
}

}  // namespace

void bind_dpp(py::module_& m) {
  bind_grid_mdp(m);
  bind_path_reward(m);
  bind_config(m);
  bind_result(m);
  bind_greedy_path(m);
  bind_solver(m);
}

}  // namespace lfdcore
