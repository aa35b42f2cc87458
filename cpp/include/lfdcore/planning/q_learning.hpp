// Q-learning on a grid (App. D.1, Alg. 3; Sutton and Barto 1998).
#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

#include "lfdcore/planning/grid_mdp.hpp"
#include "lfdcore/planning/policy.hpp"

namespace lfdcore {

using ActionValues = Eigen::Array<double, Eigen::Dynamic, action_count, Eigen::RowMajor>;

/// Sec. 4.5 prints discount .9 and K = 100, which is 99 sweeps (ERRATA 16), on soft obstacles; a discount of .9 does
/// not see beyond some 10 cells (ERRATA 31), so the other defaults here are those of ERRATA F9.
struct QLearningConfig {
  double learning_rate = 0.7;   ///< alpha, within (0, 1]
  double discount = 0.95;       ///< gamma, within (0, 1)
  int sweeps = 100;             ///< synchronous updates of all states and moves, 1..100 000
  double initial_value = -100;  ///< Q_0 of all states and moves [reward]
  bool blocked = true;          ///< moves into blocked cells do not exist; false ignores the mask (ERRATA 20)
};

/// Throws std::invalid_argument, naming the field and its bounds.
void validate(const QLearningConfig& config);

/// Q after the last sweep, in the form Q(s, a) = q(s'(s, a)).
struct QLearningResult {
  GridMdp mdp;  ///< as solved: nothing is blocked where the config says so
  QLearningConfig config;
  GridOf<double> successor_value;  ///< q (height, width) [reward]; NaN where blocked

  /// Q(s, a) [reward]; -inf for a move that is not available.
  double action_value(Cell cell, int action) const;
  /// argmax_a Q(s, a), ties to the lowest index; -1 in a blocked cell.
  int greedy_action(Cell cell) const;

  /// Q (height * width, 9), the row of a cell is iy * width + ix.
  ActionValues action_values() const;
  GridOf<std::int8_t> greedy_actions() const;
  /// max_a Q(s, a) [reward]; NaN in a blocked cell.
  GridOf<double> values() const;
};

/// The greedy path (Alg. 3) from a cell; ends by the rules of ERRATA 15. Alg. 3 names no goal: without one the usual
/// end is `stay`, on a local maximum. Where all moves tie, as on an all-zero heatmap, it wanders by the lowest index.
GreedyPath greedy_path(const QLearningResult& result, Cell start, std::optional<Cell> goal = std::nullopt);

/// Solves grid MDPs by the recursion D.1, exactly but for rounding. Keeps its workspace: from the second grid of a size
/// on `solve` into the same result does not allocate. Calls from several threads wait for each other.
class QLearningSolver {
 public:
  explicit QLearningSolver(const QLearningConfig& config = {});
  const QLearningConfig& config() const { return config_; }

  void solve(const GridMdp& mdp, QLearningResult& result);

 private:
  // A state with moves cut off at a corner, which the 3 x 3 maximum does not know.
  struct Special {
    int index = 0;  // into the padded grid
    int moves = 0;
    std::array<int, action_count> successor{};  // into the padded grid, the first `moves`
    double next = 0;
  };

  void lay_out(const GridMdp& mdp);
  void collect_specials(const GridMdp& mdp);
  void sweep();
  void write_out(QLearningResult& result) const;

  QLearningConfig config_;
  int height_ = 0, width_ = 0, stride_ = 0;
  std::vector<double> gain_, value_, rows_;
  std::vector<Special> specials_;
  std::mutex busy_;
};

}  // namespace lfdcore
