#include "lfdcore/estimation/intention_filter.hpp"

#include <utility>

#include "lfdcore/error.hpp"
#include "lfdcore/estimation/belief_update.hpp"

namespace lfdcore {

IntentionFilter::IntentionFilter(ActionModel model, Belief prior, double process_noise)
    : model_(std::move(model)),
      prior_(std::move(prior)),
      belief_(prior_),
      process_noise_(process_noise),
      scratch_(model_.scratch_size()) {
  validate(prior_, model_.goal_dimensions());
  require_between("process_noise", process_noise, 0, largest_number * largest_number, "m^2");
}

const Belief& IntentionFilter::update(std::span<const double> state, std::span<const double> action) {
  require(action.size() == static_cast<std::size_t>(model_.actions()),
          "an action must have one value for every kernel");
  const ActionVector taken = Eigen::Map<const ActionVector>(action.data(), static_cast<Eigen::Index>(action.size()));
  const Belief wider = widened(belief_, prior_, process_noise_);
  belief_ = conditioned(wider, model_.moments(state, wider, scratch_), taken);
  return belief_;
}

void IntentionFilter::reset() { belief_ = prior_; }

}  // namespace lfdcore
