// With a constant Q_0 and a reward that depends on the successor alone, all of D.1 does: what is added to Q(s, a) is
// alpha (r(s') + gamma max_a' Q(s', a') - Q(s, a)). So Q(s, a) = q(s') stays true, and one plane is iterated,
// q <- (1 - alpha) q + alpha r + alpha gamma max q over the cells that a move from s leads to: 3 x 3 around s, taken
// along rows and then across them. D.1's "arg max" is a maximum (ERRATA 30).
#include "lfdcore/planning/q_learning.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "lfdcore/error.hpp"
#include "pinched.hpp"
#include "q_sweep.hpp"

namespace lfdcore {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
constexpr double largest_initial = 1e30;

}  // namespace

void validate(const QLearningConfig& config) {
  require(config.learning_rate > 0 && config.learning_rate <= 1,
          "learning_rate is " + std::to_string(config.learning_rate) + ", must lie within (0, 1]");
  require(config.discount > 0 && config.discount < 1,
          "discount is " + std::to_string(config.discount) + ", must lie within (0, 1)");
  require_between("sweeps", config.sweeps, 1, 100000, "");
  require_between("initial_value", config.initial_value, -largest_initial, largest_initial, "reward");
}

double QLearningResult::action_value(Cell cell, int action) const {
  if (!mdp.available(cell, action)) return -inf;
  const Cell next = mdp.successor(cell, action);
  return successor_value(next.iy, next.ix);
}

int QLearningResult::greedy_action(Cell cell) const {
  int best = -1;
  double highest = -inf;
  for (int action = 0; action < action_count; ++action) {
    const double value = action_value(cell, action);
    if (value > highest) highest = value, best = action;
  }
  return best;
}

ActionValues QLearningResult::action_values() const {
  ActionValues all(mdp.reward.size(), action_count);
  for (int i = 0; i < all.rows(); ++i) {
    for (int a = 0; a < action_count; ++a) all(i, a) = action_value({i % mdp.width(), i / mdp.width()}, a);
  }
  return all;
}

GridOf<std::int8_t> QLearningResult::greedy_actions() const {
  return GridOf<std::int8_t>::NullaryExpr(mdp.height(), mdp.width(), [this](Eigen::Index iy, Eigen::Index ix) {
    return static_cast<std::int8_t>(greedy_action({static_cast<int>(ix), static_cast<int>(iy)}));
  });
}

GridOf<double> QLearningResult::values() const {
  return GridOf<double>::NullaryExpr(mdp.height(), mdp.width(), [this](Eigen::Index iy, Eigen::Index ix) {
    const Cell cell{static_cast<int>(ix), static_cast<int>(iy)};
    const int best = greedy_action(cell);
    return best < 0 ? nan : action_value(cell, best);
  });
}

GreedyPath greedy_path(const QLearningResult& result, Cell start, std::optional<Cell> goal) {
  return follow_policy(result.mdp, [&](Cell cell) { return result.greedy_action(cell); }, start, goal);
}

QLearningSolver::QLearningSolver(const QLearningConfig& config) : config_(config) { validate(config); }

void QLearningSolver::solve(const GridMdp& mdp, QLearningResult& result) {
  const std::lock_guard only_one(busy_);
  result.mdp = mdp;
  if (!config_.blocked) result.mdp.blocked.setConstant(false);
  result.config = config_;
  lay_out(result.mdp);
  collect_specials(result.mdp);
  for (int k = 0; k < config_.sweeps; ++k) sweep();
  write_out(result);
}

void QLearningSolver::lay_out(const GridMdp& mdp) {
  height_ = mdp.height();
  width_ = mdp.width();
  stride_ = (width_ / detail::q_lanes + 1) * detail::q_lanes;
  const auto cells = static_cast<std::size_t>(height_) * stride_;
  gain_.assign(cells, detail::q_blocked_value);
  value_.assign(cells + 2 * detail::q_lanes, detail::q_blocked_value);
  rows_.resize(detail::q_row_workspace(stride_));
  for (int iy = 0; iy < height_; ++iy) {
    for (int ix = 0; ix < width_; ++ix) {
      if (mdp.blocked(iy, ix)) continue;
      gain_[iy * stride_ + ix] = config_.learning_rate * mdp.reward(iy, ix);
      value_[detail::q_lanes + iy * stride_ + ix] = config_.initial_value;
    }
  }
}

void QLearningSolver::collect_specials(const GridMdp& mdp) {
  specials_.clear();
  detail::for_each_pinched(mdp.blocked, [&](Cell cell) {
    Special special;
    special.index = cell.iy * stride_ + cell.ix;
    for (int action = 0; action < action_count; ++action) {
      if (!mdp.available(cell, action)) continue;
      const Cell next = mdp.successor(cell, action);
      special.successor[special.moves++] = next.iy * stride_ + next.ix;
    }
    specials_.push_back(special);
  });
}

void QLearningSolver::sweep() {
  double* const q = value_.data() + detail::q_lanes;
  const double keep = 1 - config_.learning_rate, pull = config_.learning_rate * config_.discount;
  for (Special& special : specials_) {
    double highest = q[special.index];
    for (int i = 0; i < special.moves; ++i) highest = std::max(highest, q[special.successor[i]]);
    special.next = keep * q[special.index] + gain_[special.index] + pull * highest;
  }
  detail::q_sweep(q, gain_.data(), keep, pull, height_, stride_, rows_.data());
  for (const Special& special : specials_) q[special.index] = special.next;
}

void QLearningSolver::write_out(QLearningResult& result) const {
  result.successor_value.resize(height_, width_);
  for (int iy = 0; iy < height_; ++iy) {
    for (int ix = 0; ix < width_; ++ix) {
      const double value = value_[detail::q_lanes + iy * stride_ + ix];
      result.successor_value(iy, ix) = value < detail::q_blocked_below ? nan : value;
    }
  }
}

}  // namespace lfdcore
