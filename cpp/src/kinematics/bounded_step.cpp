#include "bounded_step.hpp"

namespace lfdcore {

JointVector bounded_step(const ChainJacobian& J, const Vector6& wanted, double damping, const JointVector& q,
                         const Eigen::VectorXd& lower, const Eigen::VectorXd& upper) {
  JointVector step = JointVector::Zero(q.size());
  ChainJacobian free = J;
  Vector6 left = wanted;
  for (int pass = 0; pass <= q.size(); ++pass) {
    Eigen::Matrix<double, 6, 6> normal = damping * Eigen::Matrix<double, 6, 6>::Identity();
    for (Eigen::Index i = 0; i < free.cols(); ++i) normal += free.col(i) * free.col(i).transpose();
    const Vector6 multipliers = normal.llt().solve(left);
    bool stopped = false;
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      if (free.col(i).isZero(0)) continue;
      step[i] = free.col(i).dot(multipliers);
      const double stop = std::clamp(q[i] + step[i], lower[i], upper[i]) - q[i];
      if (stop == step[i]) continue;
      step[i] = stop;
      left -= stop * J.col(i);
      free.col(i).setZero();
      stopped = true;
    }
    if (!stopped) break;
  }
  return step;
}

Vector6 pose_error(const Eigen::Isometry3d& wanted, const Eigen::Isometry3d& is) {
  Vector6 error;
  error << wanted.translation() - is.translation(), rotation_vector(wanted.linear() * is.linear().transpose());
  return error;
}

}  // namespace lfdcore
