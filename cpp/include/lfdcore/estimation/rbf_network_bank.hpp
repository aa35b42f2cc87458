// Many one-class RBF networks side by side, one a key (a cell of the local window, Sec. 3.3), asked all at once.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lfdcore/estimation/rbf_network.hpp"

namespace lfdcore {

class RbfNetworkBank {
 public:
  using Keys = std::vector<std::int32_t>;

  RbfNetworkBank() = default;
  /// From stored arrays: network c has the key keys[c] (ascending) and the centres offsets[c] .. offsets[c+1]-1.
  /// Throws std::invalid_argument unless they fit together and are finite.
  RbfNetworkBank(Keys keys, Keys offsets, RowMatrix centres, Eigen::VectorXd weights, double sigma);

  /// One network (Alg. 5, all targets 1) for every key that occurs; inputs (N, D), keys (N,).
  static RbfNetworkBank fit(const RowMatrix& inputs, std::span<const std::int32_t> keys,
                            const RbfNetworkConfig& config);

  /// All networks at once: their inputs are the `shared` values (S,), then the network's own row of `own` (C, D - S).
  /// Writes C estimates in [0, 1]. A NaN or infinite own value gives 0. No allocation.
  /// Throws std::invalid_argument for wrong sizes or a shared value that is not finite.
  void predict(std::span<const double> shared, std::span<const double> own, std::span<double> estimates) const;

  std::size_t size() const { return keys_.size(); }
  Eigen::Index dimensions() const { return centres_.cols(); }
  const Keys& keys() const { return keys_; }
  const Keys& offsets() const { return offsets_; }
  const RowMatrix& centres() const { return centres_; }
  const Eigen::VectorXd& weights() const { return weights_; }
  double sigma() const { return sigma_; }

 private:
  void check() const;
  void check_sizes(std::size_t shared, std::size_t own, std::size_t estimates) const;
  void add_activations(std::size_t begin, std::size_t count, std::span<const double> shared,
                       std::span<const double> own, std::span<double> estimates) const;

  Keys keys_;
  Keys offsets_ = {0};
  RowMatrix centres_;
  Eigen::VectorXd weights_;
  double sigma_ = 0.3;
  RowMatrix columns_;  // (D, M): centres by dimension, so that one loop runs over all centres
  Keys network_of_;    // (M,): whose centre it is
};

}  // namespace lfdcore
