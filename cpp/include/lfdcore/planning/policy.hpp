// Following a policy's moves over the grid until they end (path loop of Alg. 2 with the rules of ERRATA 15).
#pragma once

#include <functional>
#include <optional>
#include <string_view>

#include "lfdcore/planning/grid_mdp.hpp"
#include "lfdcore/planning/path_reward.hpp"

namespace lfdcore {

/// Why a greedy path ended.
enum class PathOutcome {
  goal,           ///< in the goal cell
  stay,           ///< the best move is to stay, short of the goal
  cycle,          ///< the next cell had been visited; H * W steps are never exceeded, since some cell repeats before
  start_blocked,  ///< the start is a blocked cell: there is no move
};

/// The outcome's name.
std::string_view to_string(PathOutcome outcome);

struct GreedyPath {
  CellPath cells;  ///< (N, 2): from the start (included) to the last cell reached; no cell twice
  PathOutcome outcome = PathOutcome::stay;
};

/// Follows `action` (a cell's best move 0..8, or -1 where none is available) from `start`.
/// Without a goal the outcome is never `goal`. Throws std::invalid_argument if the start or the goal lies outside the
/// grid.
GreedyPath follow_policy(const GridMdp& mdp, const std::function<int(Cell)>& action, Cell start,
                         std::optional<Cell> goal);

}  // namespace lfdcore
