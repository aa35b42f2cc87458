#include "lfdcore/estimation/rbf_network_bank.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

#include "gaussian_kernel.hpp"
#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

constexpr std::size_t block = 512;  // centres at a time: the scratch stays on the stack and in the L1 cache

std::vector<std::size_t> order_by_key(std::span<const std::int32_t> keys) {
  std::vector<std::size_t> order(keys.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return keys[i]; });
  return order;
}

RowMatrix rows_of(const RowMatrix& matrix, std::span<const std::size_t> rows) {
  RowMatrix picked(rows.size(), matrix.cols());
  for (std::size_t i = 0; i < rows.size(); ++i) picked.row(static_cast<Eigen::Index>(i)) = matrix.row(rows[i]);
  return picked;
}

// All networks' centres and weights, one below the other.
struct Stack {
  RowMatrix centres;
  Eigen::VectorXd weights;
};

Stack stack(const std::vector<RbfNetwork>& networks, Eigen::Index count, Eigen::Index dimensions) {
  Stack all{RowMatrix(count, dimensions), Eigen::VectorXd(count)};
  Eigen::Index at = 0;
  for (const auto& network : networks) {
    all.centres.middleRows(at, network.centres.rows()) = network.centres;
    all.weights.segment(at, network.weights.size()) = network.weights;
    at += network.weights.size();
  }
  return all;
}

}  // namespace

RbfNetworkBank::RbfNetworkBank(Keys keys, Keys offsets, RowMatrix centres, Eigen::VectorXd weights, double sigma)
    : keys_(std::move(keys)),
      offsets_(std::move(offsets)),
      centres_(std::move(centres)),
      weights_(std::move(weights)),
      sigma_(sigma) {
  check();
  columns_ = centres_.transpose();
  network_of_.resize(static_cast<std::size_t>(centres_.rows()));
  for (std::size_t c = 0; c < keys_.size(); ++c)
    std::fill(network_of_.begin() + offsets_[c], network_of_.begin() + offsets_[c + 1], static_cast<std::int32_t>(c));
}

void RbfNetworkBank::check() const {
  require_positive("sigma", sigma_, "");
  require(offsets_.size() == keys_.size() + 1, "offsets has " + std::to_string(offsets_.size()) + " entries, " +
                                                   std::to_string(keys_.size()) + " keys need one more than keys");
  require(offsets_.front() == 0 && offsets_.back() == centres_.rows() && std::ranges::is_sorted(offsets_),
          "offsets must rise from 0 to the number of centres, " + std::to_string(centres_.rows()));
  require(std::ranges::adjacent_find(keys_, std::greater_equal<>{}) == keys_.end(), "keys must rise strictly");
  require(weights_.size() == centres_.rows(),
          std::to_string(weights_.size()) + " weights for " + std::to_string(centres_.rows()) + " centres");
  require(centres_.allFinite() && weights_.allFinite(), "centres and weights must be finite");
}

RbfNetworkBank RbfNetworkBank::fit(const RowMatrix& inputs, std::span<const std::int32_t> keys,
                                   const RbfNetworkConfig& config) {
  validate(config);
  require(static_cast<std::size_t>(inputs.rows()) == keys.size(),
          std::to_string(inputs.rows()) + " training inputs but " + std::to_string(keys.size()) + " keys");
  require(inputs.rows() > 0, "a bank needs at least one training input");
  require(inputs.allFinite(), "training inputs must be finite");
  const auto order = order_by_key(keys);
  Keys found, offsets{0};
  std::vector<RbfNetwork> networks;
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    while (end < order.size() && keys[order[end]] == keys[order[begin]]) ++end;
    const auto mine = std::span(order).subspan(begin, end - begin);
    networks.push_back(fit_rbf_network(rows_of(inputs, mine), Eigen::VectorXd::Ones(mine.size()), config));
    found.push_back(keys[order[begin]]);
    offsets.push_back(offsets.back() + static_cast<std::int32_t>(networks.back().weights.size()));
  }
  auto all = stack(networks, offsets.back(), inputs.cols());
  return {std::move(found), std::move(offsets), std::move(all.centres), std::move(all.weights), config.sigma};
}

void RbfNetworkBank::predict(std::span<const double> shared, std::span<const double> own,
                             std::span<double> estimates) const {
  check_sizes(shared.size(), own.size(), estimates.size());
  for (const double value : shared) require_finite("a shared input", value, "");
  std::ranges::fill(estimates, 0.0);
  const auto total = static_cast<std::size_t>(weights_.size());
  for (std::size_t begin = 0; begin < total; begin += block)
    add_activations(begin, std::min(block, total - begin), shared, own, estimates);
  for (double& y : estimates) y = y > 0 ? std::min(y, 1.0) : 0.0;  // NaN -> 0
}

void RbfNetworkBank::check_sizes(std::size_t shared, std::size_t own, std::size_t estimates) const {
  const auto dimensions = static_cast<std::size_t>(columns_.rows());
  const auto text = [](std::size_t number) { return std::to_string(number); };  // built only when it is needed
  if (shared > dimensions)
    throw std::invalid_argument(text(shared) + " shared inputs, the networks have " + text(dimensions) + " in all");
  if (own != (dimensions - shared) * size())
    throw std::invalid_argument("own inputs must be (" + text(size()) + ", " + text(dimensions - shared) + "), got " +
                                text(own) + " values");
  if (estimates != size()) throw std::invalid_argument("the output must hold " + text(size()) + " estimates");
}

void RbfNetworkBank::add_activations(std::size_t begin, std::size_t count, std::span<const double> shared,
                                     std::span<const double> own, std::span<double> estimates) const {
  const std::size_t owned = static_cast<std::size_t>(columns_.rows()) - shared.size();
  std::array<double, block> values;
  std::fill_n(values.begin(), count, 0.0);
  for (std::size_t d = 0; d < shared.size(); ++d)
    detail::add_squared_distance(values.data(), columns_.row(d).data() + begin, shared[d], count);
  for (std::size_t d = 0; d < owned; ++d) {
    const double* column = columns_.row(shared.size() + d).data() + begin;
    for (std::size_t i = 0; i < count; ++i) {
      const double off = column[i] - own[static_cast<std::size_t>(network_of_[begin + i]) * owned + d];
      values[i] += off * off;
    }
  }
  detail::weighted_exp(values.data(), weights_.data() + begin, 0.5 / (sigma_ * sigma_), count);
  for (std::size_t i = 0; i < count; ++i) estimates[static_cast<std::size_t>(network_of_[begin + i])] += values[i];
}

}  // namespace lfdcore
