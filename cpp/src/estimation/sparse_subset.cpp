#include "lfdcore/estimation/sparse_subset.hpp"

#include <algorithm>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include "greedy_basis.hpp"
#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

using detail::GreedyBasis;
using detail::lanes;
using Eigen::Index;

// The samples left; draws some of them to its front.
class Urn {
 public:
  Urn(Index count, std::uint64_t seed) : left_(static_cast<std::size_t>(count)), state_(seed) {
    std::iota(left_.begin(), left_.end(), Index{0});
  }
  std::span<const Index> draw(std::size_t count) {
    count = std::min(count, left_.size());
    for (std::size_t i = 0; i < count; ++i) {
      state_ = state_ * 6364136223846793005u + 1442695040888963407u;
      std::swap(left_[i], left_[i + (state_ >> 33) % (left_.size() - i)]);
    }
    return {left_.data(), count};
  }
  void remove(std::size_t position) {
    left_[position] = left_.back();
    left_.pop_back();
  }

 private:
  std::vector<Index> left_;
  std::uint64_t state_;
};

// One action standardised: Q_a in units of its variance; an action that never changes counts as it is.
double weight_of(const Eigen::VectorXd& actions) {
  const double variance = (actions.array() - actions.mean()).square().mean();
  return variance > 0 ? 1 / variance : 1;
}

struct Weighted {
  GreedyBasis basis;
  double weight;
  GreedyBasis::Lanes now, best;  // of the 32 candidates looked at, and of those with the best one
};

struct Choice {
  double gain = -1;
  Index sample = 0;
  std::size_t position = 0;
};

// -> the best of these candidates, if it is better than `best`
Choice better(const Choice& best, std::span<const Index> candidates, std::size_t first,
              const std::vector<Weighted>& actions) {
  Choice found = best;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    double gain = 0;
    for (const Weighted& action : actions) gain += action.weight * action.now.gain[i];
    if (gain > found.gain || (gain == found.gain && candidates[i] < found.sample))
      found = {gain, candidates[i], first + i};
  }
  return found;
}

Choice choose(std::span<const Index> candidates, std::vector<Weighted>& actions) {
  Choice best;
  for (std::size_t first = 0; first < candidates.size(); first += lanes) {
    const auto some = candidates.subspan(first, std::min<std::size_t>(lanes, candidates.size() - first));
    for (Weighted& action : actions) action.basis.evaluate(some.data(), static_cast<int>(some.size()), action.now);
    const Choice found = better(best, some, first, actions);
    if (found.gain == best.gain && found.sample == best.sample) continue;
    best = found;
    for (Weighted& action : actions) std::swap(action.now, action.best);
  }
  for (Weighted& action : actions) action.basis.select(action.best, static_cast<int>(best.position % lanes));
  return best;
}

}  // namespace

std::vector<std::int64_t> select_subset(const RowMatrix& states, const RowMatrix& goals, const RowMatrix& actions,
                                        const std::vector<ActionKernel>& kernels, int size, int candidates,
                                        std::uint64_t seed) {
  detail::check_action_data(states, goals, actions, kernels);
  const Index N = states.rows();
  require(size >= 1 && size <= N, "the subset's size is " + std::to_string(size) + ", must be in [1, " +
                                      std::to_string(N) + "], the number of samples");
  require(candidates >= 1, "candidates is " + std::to_string(candidates) + ", must be at least 1");
  const detail::SubnormalsFlushed flushed;
  std::vector<Index> all(static_cast<std::size_t>(N));
  std::iota(all.begin(), all.end(), Index{0});
  const RowMatrix inputs = detail::joint_inputs(states, goals, all);
  std::vector<Weighted> weighted;
  for (Index a = 0; a < actions.cols(); ++a) {
    GreedyBasis basis(inputs, actions.col(a), kernels[static_cast<std::size_t>(a)], size);
    auto now = basis.make_lanes(), best = now;
    weighted.push_back({std::move(basis), weight_of(actions.col(a)), std::move(now), std::move(best)});
  }
  Urn urn(N, seed);
  std::vector<std::int64_t> selected;
  while (selected.size() < static_cast<std::size_t>(size)) {
    const Choice chosen = choose(urn.draw(static_cast<std::size_t>(candidates)), weighted);
    selected.push_back(chosen.sample);
    urn.remove(chosen.position);
  }
  return selected;
}

}  // namespace lfdcore
