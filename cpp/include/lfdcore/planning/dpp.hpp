// Dynamic policy programming on a grid (App. D.2, Alg. 2; Azar et al. 2012).
#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <vector>

#include "lfdcore/planning/grid_mdp.hpp"
#include "lfdcore/planning/policy.hpp"

namespace lfdcore {

/// Action preferences Psi(s, a): (height * width, 9), the row of a cell is iy * width + ix.
using Preferences = Eigen::Array<double, Eigen::Dynamic, action_count, Eigen::RowMajor>;
using DoubleGrid = GridOf<double>;
using ActionGrid = GridOf<std::int8_t>;

/// Sec. 3.5 prints discount .99, inverse_temperature .001 and K = 100, which is 99 sweeps (ERRATA 16), on soft
/// obstacles; the other defaults here are those of ERRATA F8.
struct DppConfig {
  double discount = 0.99;              ///< gamma, within (0, 1)
  double inverse_temperature = 0.001;  ///< eta [1 / reward], positive
  int sweeps = 300;                    ///< synchronous updates of all states, 1..100 000
  bool blocked = true;                 ///< moves into blocked cells do not exist; false ignores the mask (ERRATA 20)
};

/// Throws std::invalid_argument, naming the field and its bounds.
void validate(const DppConfig& config);

/// Psi after the last sweep, in the form Psi(s, a) = Psi_0(s, a) + A(s'(s, a)) - B(s).
struct DppResult {
  GridMdp mdp;  ///< as solved: nothing is blocked where the config says so
  DppConfig config;
  Preferences initial;        ///< Psi_0; no rows: 0
  DoubleGrid successor_part;  ///< A (height, width) [reward]; NaN where blocked
  DoubleGrid state_part;      ///< B (height, width) [reward]; NaN where blocked

  /// Psi(s, a) [reward]; -inf for a move that is not available.
  double preference(Cell cell, int action) const;
  /// argmax_a Psi(s, a), ties to the lowest index; -1 in a blocked cell.
  int greedy_action(Cell cell) const;
  /// M_eta Psi(s), the Boltzmann mean of D.8 [reward]; NaN in a blocked cell.
  double value(Cell cell) const;

  Preferences preferences() const;
  ActionGrid greedy_actions() const;
  DoubleGrid values() const;
};

/// The greedy path (Alg. 2) from a cell; ends by the rules of ERRATA 15.
GreedyPath greedy_path(const DppResult& result, Cell start, Cell goal);

/// Psi_0 = (log pi_0 + entropy(pi_0)) / eta of a baseline that follows the path (ERRATA 19): `probability` on the
/// path's move (to stay on its last cell), the rest shared by the other 8; uniform, so Psi_0 = 0, off the path. A cell
/// that the path visits twice keeps its later move. Throws std::invalid_argument unless 0 < probability < 1,
/// inverse_temperature > 0 and consecutive cells are neighbours in the grid.
Preferences baseline_preference(const CellPath& path, int height, int width, double probability,
                                double inverse_temperature);

/// Solves grid MDPs by the recursion D.7, exactly but for rounding. Keeps its workspace: from the second grid of a
/// size on `solve` into the same result does not allocate. Calls from several threads wait for each other.
class DppSolver {
 public:
  explicit DppSolver(const DppConfig& config = {});
  const DppConfig& config() const { return config_; }

  /// From Psi_0 = 0. Throws std::invalid_argument if rewards are so large against the temperature (exponents beyond
  /// 1e9) that doubles cannot hold the policy.
  void solve(const GridMdp& mdp, DppResult& result);
  /// From a given Psi_0, finite, (height * width, 9). States whose row is not 0 cost 9 exponentials each a sweep.
  void solve(const GridMdp& mdp, const Preferences& initial, DppResult& result);

 private:
  // A state that the stencil gets wrong: moves cut off at a corner, or a Psi_0 of its own.
  struct Special {
    int index = 0;  // into the padded grid
    int moves = 0;
    std::array<int, action_count> successor{};   // into the padded grid, the first `moves`
    std::array<double, action_count> initial{};  // Psi_0 in exponent units
  };

  void check_exponents(const DppResult& result) const;
  void lay_out(const DppResult& result);
  void collect_specials(const DppResult& result);
  void add_special(const DppResult& result, Cell cell);
  void sweep(int number);
  double mean_at(const Special& special) const;
  void write_out(DppResult& result) const;

  DppConfig config_;
  int height_ = 0, width_ = 0, stride_ = 0;
  std::vector<double> reward_, now_, next_, self_inner_, self_outer_, rows_;
  std::vector<Special> specials_;
  std::mutex busy_;
};

}  // namespace lfdcore
