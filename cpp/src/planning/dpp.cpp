// D.5-D.6 with their superscripts put right are D.7 with log-sum-exp; the Boltzmann mean of D.7-D.8, used here, has the
// same limit (ERRATA 17). Every exponent is relative to the largest, as D.8 overflows otherwise (ERRATA 18).
// D.7 with a deterministic successor s'(s, a) adds r(s') + gamma M(s') - M(s) to Psi(s, a). So Psi keeps the form
// Psi_0(s, a) + A(s') - B(s), where A += r + gamma M and B += M = Q - B with Q(s) the Boltzmann mean (D.8) of
// Psi_0(s, a) + A(s'). Hence B_{k+1} = Q_k and, summed up, A_{k+1} = (k + 1) r + gamma Q_k: only A is iterated.
// It is kept in exponent units, y = A eta log2(e), so that the weights of D.8 are 2^y.
#include "lfdcore/planning/dpp.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

#include "dpp_sweep.hpp"
#include "lfdcore/error.hpp"
#include "pinched.hpp"

namespace lfdcore {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
constexpr double log2_e = 1.4426950408889634;
constexpr double largest_exponent = 1e9;

// The numbers of out-of-grid moves of a row of cells, where `rows_inside` of the 3 rows of moves stay in the grid.
void count_outside(std::vector<double>& self, int width, int rows_inside) {
  for (int ix = 0; ix < width; ++ix) {
    const int columns_inside = 1 + (ix > 0) + (ix + 1 < width);
    self[ix] = action_count - rows_inside * columns_inside;
  }
}

void require_preferences(const GridMdp& mdp, const Preferences& initial) {
  if (initial.rows() != mdp.reward.size()) {
    throw std::invalid_argument("initial preference has " + std::to_string(initial.rows()) + " states, must have " +
                                std::to_string(mdp.reward.size()) + " (height * width)");
  }
  if (!initial.allFinite()) throw std::invalid_argument("initial preference holds NaN or infinity");
}

}  // namespace

void validate(const DppConfig& config) {
  require(config.discount > 0 && config.discount < 1,
          "discount is " + std::to_string(config.discount) + ", must lie within (0, 1)");
  require_positive("inverse_temperature", config.inverse_temperature, "1/reward");
  require_between("sweeps", config.sweeps, 1, 100000, "");
}

double DppResult::preference(Cell cell, int action) const {
  if (!mdp.available(cell, action)) return -inf;
  const Cell next = mdp.successor(cell, action);
  const double start = initial.rows() > 0 ? initial(cell.iy * mdp.width() + cell.ix, action) : 0.0;
  return start + successor_part(next.iy, next.ix) - state_part(cell.iy, cell.ix);
}

int DppResult::greedy_action(Cell cell) const {
  int best = -1;
  double highest = -inf;
  for (int action = 0; action < action_count; ++action) {
    const double preferred = preference(cell, action);
    if (preferred > highest) highest = preferred, best = action;
  }
  return best;
}

double DppResult::value(Cell cell) const {
  const int best = greedy_action(cell);
  if (best < 0) return nan;
  const double highest = preference(cell, best);
  double sum = 0, weighted = 0;
  for (int action = 0; action < action_count; ++action) {
    const double preferred = preference(cell, action);
    const double weight = std::exp(config.inverse_temperature * (preferred - highest));
    if (weight > 0) sum += weight, weighted += weight * preferred;
  }
  return weighted / sum;  // D.8
}

Preferences DppResult::preferences() const {
  Preferences all(mdp.reward.size(), action_count);
  for (int i = 0; i < all.rows(); ++i) {
    for (int a = 0; a < action_count; ++a) all(i, a) = preference({i % mdp.width(), i / mdp.width()}, a);
  }
  return all;
}

ActionGrid DppResult::greedy_actions() const {
  return ActionGrid::NullaryExpr(mdp.height(), mdp.width(), [this](Eigen::Index iy, Eigen::Index ix) {
    return static_cast<std::int8_t>(greedy_action({static_cast<int>(ix), static_cast<int>(iy)}));
  });
}

DoubleGrid DppResult::values() const {
  return DoubleGrid::NullaryExpr(mdp.height(), mdp.width(), [this](Eigen::Index iy, Eigen::Index ix) {
    return value({static_cast<int>(ix), static_cast<int>(iy)});
  });
}

GreedyPath greedy_path(const DppResult& result, Cell start, Cell goal) {
  return follow_policy(result.mdp, [&](Cell cell) { return result.greedy_action(cell); }, start, goal);
}

Preferences baseline_preference(const CellPath& path, int height, int width, double probability,
                                double inverse_temperature) {
  require(height > 0 && width > 0, "grid is " + std::to_string(height) + " x " + std::to_string(width) +
                                       " cells, must have at least 1 x 1 (height x width)");
  require(probability > 0 && probability < 1,
          "probability is " + std::to_string(probability) + ", must lie within (0, 1)");
  require_positive("inverse_temperature", inverse_temperature, "1/reward");
  const double log_move = std::log(probability), log_other = std::log((1 - probability) / (action_count - 1));
  const double entropy = -probability * log_move - (1 - probability) * log_other;
  Preferences start = Preferences::Zero(static_cast<Eigen::Index>(height) * width, action_count);
  for (Eigen::Index i = 0; i < path.rows(); ++i) {
    const int ix = path(i, 0), iy = path(i, 1);
    const bool last = i + 1 == path.rows();
    const int dx = last ? 0 : path(i + 1, 0) - ix, dy = last ? 0 : path(i + 1, 1) - iy;
    require(ix >= 0 && iy >= 0 && ix < width && iy < height && std::abs(dx) <= 1 && std::abs(dy) <= 1,
            "path cell " + std::to_string(i) + " is (" + std::to_string(ix) + ", " + std::to_string(iy) +
                "), must lie in the grid and next to its follower");
    start.row(iy * width + ix) = (log_other + entropy) / inverse_temperature;
    start(iy * width + ix, (dy + 1) * 3 + dx + 1) = (log_move + entropy) / inverse_temperature;
  }
  return start;
}

DppSolver::DppSolver(const DppConfig& config) : config_(config) { validate(config); }

void DppSolver::solve(const GridMdp& mdp, DppResult& result) {
  const Preferences none(0, action_count);
  solve(mdp, none, result);
}

void DppSolver::solve(const GridMdp& mdp, const Preferences& initial, DppResult& result) {
  const std::lock_guard only_one(busy_);
  if (initial.rows() > 0) require_preferences(mdp, initial);
  result.mdp = mdp;
  if (!config_.blocked) result.mdp.blocked.setConstant(false);
  result.config = config_;
  result.initial = initial;
  check_exponents(result);
  lay_out(result);
  collect_specials(result);
  for (int k = 1; k <= config_.sweeps; ++k) sweep(k);
  write_out(result);
}

void DppSolver::check_exponents(const DppResult& result) const {
  const double largest_reward = result.mdp.reward.abs().maxCoeff();
  const double horizon = std::min<double>(config_.sweeps, 1 / (1 - config_.discount));
  const double start = result.initial.rows() > 0 ? result.initial.abs().maxCoeff() : 0.0;
  const double exponent =
      config_.inverse_temperature * (largest_reward * config_.sweeps * horizon + start / (1 - config_.discount));
  if (exponent <= largest_exponent) return;
  std::ostringstream text;
  text << "inverse_temperature " << config_.inverse_temperature << " with rewards up to " << largest_reward
       << " gives exponents up to " << exponent << ", must be at most " << largest_exponent;
  throw std::invalid_argument(text.str());
}

void DppSolver::lay_out(const DppResult& result) {
  const GridMdp& mdp = result.mdp;
  height_ = mdp.height();
  width_ = mdp.width();
  stride_ = (width_ + detail::lane_padding - 1) / detail::lane_padding * detail::lane_padding;
  const auto cells = static_cast<std::size_t>(height_) * stride_;
  reward_.assign(cells, detail::blocked_value);
  now_.assign(cells, detail::blocked_value);
  next_.resize(cells);
  rows_.resize(detail::row_workspace(stride_));
  const double unit = config_.inverse_temperature * log2_e;
  for (int iy = 0; iy < height_; ++iy) {
    for (int ix = 0; ix < width_; ++ix) {
      if (mdp.blocked(iy, ix)) continue;
      reward_[iy * stride_ + ix] = unit * mdp.reward(iy, ix);
      now_[iy * stride_ + ix] = 0;
    }
  }
  self_inner_.assign(stride_, 0);
  self_outer_.assign(stride_, 0);
  count_outside(self_inner_, width_, 3);
  count_outside(self_outer_, width_, height_ == 1 ? 1 : 2);
}

void DppSolver::collect_specials(const DppResult& result) {
  specials_.clear();
  detail::for_each_pinched(result.mdp.blocked, [&](Cell cell) { add_special(result, cell); });
  for (int i = 0; i < result.initial.rows(); ++i) {
    if ((result.initial.row(i) != 0).any()) add_special(result, {i % width_, i / width_});
  }
}

void DppSolver::add_special(const DppResult& result, Cell cell) {
  Special special;
  special.index = cell.iy * stride_ + cell.ix;
  for (int action = 0; action < action_count; ++action) {
    if (!result.mdp.available(cell, action)) continue;
    const Cell next = result.mdp.successor(cell, action);
    special.successor[special.moves] = next.iy * stride_ + next.ix;
    const double start = result.initial.rows() > 0 ? result.initial(cell.iy * width_ + cell.ix, action) : 0.0;
    special.initial[special.moves++] = start * config_.inverse_temperature * log2_e;
  }
  if (special.moves > 0) specials_.push_back(special);
}

void DppSolver::sweep(int number) {
  const detail::SweepGrid grid{height_, stride_, reward_.data(), self_inner_.data(), self_outer_.data(), rows_.data()};
  detail::sweep_grid(grid, now_.data(), config_.discount, number, next_.data());
  for (const Special& special : specials_) {
    next_[special.index] = number * reward_[special.index] + config_.discount * mean_at(special);
  }
  now_.swap(next_);
}

// The Boltzmann mean of D.8, literally.
double DppSolver::mean_at(const Special& special) const {
  std::array<double, action_count> y{};
  double highest = -inf, sum = 0, weighted = 0;
  for (int i = 0; i < special.moves; ++i) {
    y[i] = special.initial[i] + now_[special.successor[i]];
    highest = std::max(highest, y[i]);
  }
  for (int i = 0; i < special.moves; ++i) {
    const double weight = std::exp2(y[i] - highest);
    sum += weight;
    weighted += weight * y[i];
  }
  return weighted / sum;
}

void DppSolver::write_out(DppResult& result) const {
  const double unit = config_.inverse_temperature * log2_e;
  result.successor_part.resize(height_, width_);
  result.state_part.resize(height_, width_);
  for (int iy = 0; iy < height_; ++iy) {
    for (int ix = 0; ix < width_; ++ix) {
      const int at = iy * stride_ + ix;
      const bool blocked = result.mdp.blocked(iy, ix);
      result.successor_part(iy, ix) = blocked ? nan : now_[at] / unit;
      // A_K = K r + gamma B_K
      result.state_part(iy, ix) = blocked ? nan : (now_[at] - config_.sweeps * reward_[at]) / (config_.discount * unit);
    }
  }
}

}  // namespace lfdcore
