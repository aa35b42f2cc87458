#include "lfdcore/planning/policy.hpp"

#include <array>
#include <string>
#include <vector>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

void require_inside(const char* name, const GridMdp& mdp, Cell cell) {
  require(mdp.contains(cell), std::string(name) + " cell is (" + std::to_string(cell.ix) + ", " +
                                  std::to_string(cell.iy) + "), must lie in the grid of " +
                                  std::to_string(mdp.width()) + " x " + std::to_string(mdp.height()) +
                                  " cells (width x height)");
}

CellPath as_rows(const std::vector<Cell>& cells) {
  CellPath rows(static_cast<Eigen::Index>(cells.size()), 2);
  for (Eigen::Index i = 0; i < rows.rows(); ++i) rows.row(i) << cells[i].ix, cells[i].iy;
  return rows;
}

}  // namespace

std::string_view to_string(PathOutcome outcome) {
  constexpr std::array<std::string_view, 4> names{"goal", "stay", "cycle", "start_blocked"};
  return names[static_cast<std::size_t>(outcome)];
}

GreedyPath follow_policy(const GridMdp& mdp, const std::function<int(Cell)>& action, Cell start,
                         std::optional<Cell> goal) {
  require_inside("start", mdp, start);
  if (goal) require_inside("goal", mdp, *goal);
  if (mdp.blocked(start.iy, start.ix)) return {as_rows({start}), PathOutcome::start_blocked};
  Mask visited = Mask::Constant(mdp.height(), mdp.width(), false);
  std::vector<Cell> cells;
  for (Cell at = start;;) {
    visited(at.iy, at.ix) = true;
    cells.push_back(at);
    if (at == goal) return {as_rows(cells), PathOutcome::goal};
    const Cell next = mdp.successor(at, action(at));
    if (next == at) return {as_rows(cells), PathOutcome::stay};
    if (visited(next.iy, next.ix)) return {as_rows(cells), PathOutcome::cycle};
    at = next;
  }
}

}  // namespace lfdcore
