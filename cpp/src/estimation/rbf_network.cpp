#include "lfdcore/estimation/rbf_network.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

// A new column is skipped where less than this share (of its squared length) is independent of the chosen ones.
constexpr double independent_share = 1e-10;

Eigen::VectorXd activations(const RowMatrix& inputs, const Eigen::RowVectorXd& centre, double sigma) {
  const Eigen::VectorXd squared = (inputs.rowwise() - centre).rowwise().squaredNorm();
  return (squared.array() * (-0.5 / (sigma * sigma))).exp();
}

// The least-squares fit grown one column at a time: A = Q R by Gram-Schmidt, so adding a basis function costs O(N n)
// instead of a fit from scratch, and the residual is at hand.
class GrowingFit {
 public:
  explicit GrowingFit(const Eigen::VectorXd& targets, Eigen::Index most)
      : residual(targets), Q_(targets.size(), most), R_(Eigen::MatrixXd::Zero(most, most)), projection_(most) {}

  // False, and nothing done, if the column depends on those taken before.
  bool take(Eigen::VectorXd column) {
    const double length = column.squaredNorm();
    auto chosen = Q_.leftCols(count_);
    for (int pass = 0; pass < 2; ++pass) {  // twice is enough to be orthogonal to rounding
      const Eigen::VectorXd along = chosen.transpose() * column;
      column -= chosen * along;
      R_.col(count_).head(count_) += along;
    }
    if (!(column.squaredNorm() > independent_share * length)) {
      R_.col(count_).setZero();
      return false;
    }
    R_(count_, count_) = column.norm();
    Q_.col(count_) = column / R_(count_, count_);
    projection_(count_) = Q_.col(count_).dot(residual);
    residual -= projection_(count_) * Q_.col(count_);
    ++count_;
    return true;
  }

  Eigen::VectorXd weights() const {
    return R_.topLeftCorner(count_, count_).triangularView<Eigen::Upper>().solve(projection_.head(count_));
  }

  Eigen::VectorXd residual;

 private:
  Eigen::MatrixXd Q_, R_;
  Eigen::VectorXd projection_;
  Eigen::Index count_ = 0;
};

void check_training_data(const RowMatrix& inputs, const Eigen::VectorXd& targets) {
  require(inputs.rows() > 0 && inputs.cols() > 0, "a network needs at least one training input, got shape (" +
                                                      std::to_string(inputs.rows()) + ", " +
                                                      std::to_string(inputs.cols()) + ")");
  require(inputs.rows() == targets.size(),
          std::to_string(inputs.rows()) + " training inputs but " + std::to_string(targets.size()) + " targets");
  require(inputs.allFinite() && targets.allFinite(), "training inputs and targets must be finite");
}

}  // namespace

void validate(const RbfNetworkConfig& config) {
  require_positive("sigma", config.sigma, "");
  require_between("threshold", config.threshold, 0.0, 1e300, "");
  require_between("max_centres", config.max_centres, 1, 1e6, "basis functions");
}

RbfNetwork fit_rbf_network(const RowMatrix& inputs, const Eigen::VectorXd& targets, const RbfNetworkConfig& config) {
  validate(config);
  check_training_data(inputs, targets);
  const Eigen::Index most = std::min<Eigen::Index>(inputs.rows(), config.max_centres);
  GrowingFit fit(targets, most);
  Eigen::ArrayXd open = Eigen::ArrayXd::Ones(inputs.rows());  // 0: taken or useless as a centre
  std::vector<Eigen::Index> centres;
  while (static_cast<Eigen::Index>(centres.size()) < most) {
    Eigen::Index worst = 0;
    const double error = fit.residual.array().square().maxCoeff();
    if (error < config.threshold) break;
    if ((fit.residual.array().square() * open).maxCoeff(&worst) <= 0) break;
    open(worst) = 0;
    if (fit.take(activations(inputs, inputs.row(worst), config.sigma))) centres.push_back(worst);
  }
  RbfNetwork network{RowMatrix(centres.size(), inputs.cols()), fit.weights(), config.sigma};
  for (std::size_t j = 0; j < centres.size(); ++j)
    network.centres.row(static_cast<Eigen::Index>(j)) = inputs.row(centres[j]);
  return network;
}

Eigen::VectorXd RbfNetwork::predict(const RowMatrix& inputs) const {
  require(inputs.cols() == centres.cols(), "inputs have " + std::to_string(inputs.cols()) +
                                               " columns, the network has " + std::to_string(centres.cols()));
  Eigen::VectorXd estimate = Eigen::VectorXd::Zero(inputs.rows());
  for (Eigen::Index j = 0; j < centres.rows(); ++j) estimate += weights(j) * activations(inputs, centres.row(j), sigma);
  return estimate.unaryExpr([](double y) { return y > 0 ? std::min(y, 1.0) : 0.0; });  // NaN -> 0
}

}  // namespace lfdcore
