#include "action_samples.hpp"

#include <cmath>
#include <map>
#include <string>
#include <string_view>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

void require_scale(std::string_view name, double value, std::string_view unit) {
  require_positive(name, value, unit);
  require_between(name, value, 1 / largest_number, largest_number, unit);
}

void require_usable(std::string_view name, const RowMatrix& values) {
  require(values.allFinite(), "states, goals and actions must be finite, drop samples with NaN");
  require_between(name, values.size() > 0 ? values.cwiseAbs().maxCoeff() : 0, 0, largest_number, "(the largest)");
}

}  // namespace

void validate(const ActionKernel& kernel) {
  require_scale("amplitude", kernel.amplitude, "");
  require_between("noise", kernel.noise, 0, largest_number, "(a standard deviation)");
  require(kernel.state_lengthscales.size() > 0, "an action kernel needs a length-scale for every state dimension");
  require(kernel.goal_lengthscales.size() > 0 && kernel.goal_lengthscales.size() <= most_goal_dimensions,
          "an action kernel has " + std::to_string(kernel.goal_lengthscales.size()) +
              " goal length-scales, must have 1 to " + std::to_string(most_goal_dimensions));
  for (const double l : kernel.state_lengthscales) require_scale("a state length-scale", l, "");
  for (const double l : kernel.goal_lengthscales) require_scale("a goal length-scale", l, "m");
}

namespace detail {

void check_action_data(const RowMatrix& states, const RowMatrix& goals, const RowMatrix& actions,
                       const std::vector<ActionKernel>& kernels) {
  const Eigen::Index N = states.rows();
  require(N > 0, "an action model needs at least one sample, got none");
  require(goals.rows() == N && actions.rows() == N, std::to_string(N) + " states but " + std::to_string(goals.rows()) +
                                                        " goals and " + std::to_string(actions.rows()) + " actions");
  require(
      actions.cols() > 0 && actions.cols() <= most_actions,
      "actions have " + std::to_string(actions.cols()) + " columns, must have 1 to " + std::to_string(most_actions));
  require(kernels.size() == static_cast<std::size_t>(actions.cols()),
          std::to_string(kernels.size()) + " kernels for " + std::to_string(actions.cols()) + " actions");
  for (const auto& kernel : kernels) {
    validate(kernel);
    require(kernel.state_lengthscales.size() == states.cols() && kernel.goal_lengthscales.size() == goals.cols(),
            "states and goals have " + std::to_string(states.cols()) + " and " + std::to_string(goals.cols()) +
                " columns, a kernel has " + std::to_string(kernel.state_lengthscales.size()) + " and " +
                std::to_string(kernel.goal_lengthscales.size()) + " length-scales");
  }
  require_usable("a state", states);
  require_usable("a goal", goals);
  require_usable("an action", actions);
}

void check_subset(const std::vector<std::int64_t>& subset, Eigen::Index count) {
  require(!subset.empty(), "the subset is empty");
  std::vector<bool> named(static_cast<std::size_t>(count), false);
  for (const auto i : subset) {
    require(i >= 0 && i < count,
            "the subset names sample " + std::to_string(i) + ", must be in [0, " + std::to_string(count - 1) + "]");
    require(!named[static_cast<std::size_t>(i)], "the subset names sample " + std::to_string(i) + " twice");
    named[static_cast<std::size_t>(i)] = true;
  }
}

RowMatrix joint_inputs(const RowMatrix& states, const RowMatrix& goals, const std::vector<Eigen::Index>& chosen) {
  RowMatrix inputs(static_cast<Eigen::Index>(chosen.size()), states.cols() + goals.cols());
  for (Eigen::Index n = 0; n < inputs.rows(); ++n)
    inputs.row(n) << states.row(chosen[static_cast<std::size_t>(n)]), goals.row(chosen[static_cast<std::size_t>(n)]);
  return inputs;
}

Eigen::VectorXd joint_lengthscales(const ActionKernel& kernel) {
  Eigen::VectorXd joint(kernel.state_lengthscales.size() + kernel.goal_lengthscales.size());
  joint << kernel.state_lengthscales, kernel.goal_lengthscales;
  return joint;
}

std::vector<double> scaled_blocks(const RowMatrix& inputs, const Eigen::VectorXd& lengthscales) {
  const Eigen::Index dims = inputs.cols();
  std::vector<double> blocks(std::size_t(blocks_of(inputs.rows())) * dims * lanes);
  for (Eigen::Index n = 0; n < inputs.rows(); ++n)
    for (Eigen::Index d = 0; d < dims; ++d)
      blocks[static_cast<std::size_t>((n / lanes * dims + d) * lanes + n % lanes)] = inputs(n, d) / lengthscales(d);
  return blocks;
}

std::vector<double> padded_columns(const RowMatrix& rows) {
  const std::size_t padded = std::size_t(blocks_of(rows.rows())) * lanes;
  std::vector<double> columns(padded * static_cast<std::size_t>(rows.cols()));
  for (Eigen::Index d = 0; d < rows.cols(); ++d)
    for (Eigen::Index n = 0; n < rows.rows(); ++n)
      columns[static_cast<std::size_t>(d) * padded + static_cast<std::size_t>(n)] = rows(n, d);
  return columns;
}

SharedGoals shared_goals(const RowMatrix& goals) {
  std::map<std::vector<double>, Eigen::Index> numbers;
  SharedGoals shared;
  for (Eigen::Index n = 0; n < goals.rows(); ++n) {
    const std::vector<double> goal(goals.row(n).begin(), goals.row(n).end());
    shared.number.push_back(numbers.try_emplace(goal, static_cast<Eigen::Index>(numbers.size())).first->second);
  }
  shared.goals.resize(static_cast<Eigen::Index>(numbers.size()), goals.cols());
  for (const auto& [goal, number] : numbers)
    shared.goals.row(number) = Eigen::Map<const Eigen::RowVectorXd>(goal.data(), goals.cols());
  return shared;
}

}  // namespace detail
}  // namespace lfdcore
