#include "interaction_model.hpp"

#include <Eigen/QR>
#include <string>

#include "lfdcore/error.hpp"
#include "small_products.hpp"

namespace lfdcore::detail {
namespace {

void require_shape(const char* name, const RowMatrix& matrix, Eigen::Index rows, Eigen::Index columns) {
  require(matrix.rows() == rows && matrix.cols() == columns,
          std::string(name) + " has shape (" + std::to_string(matrix.rows()) + ", " + std::to_string(matrix.cols()) +
              "), must have (" + std::to_string(rows) + ", " + std::to_string(columns) + ")");
  require(matrix.allFinite(), std::string(name) + " must be finite");
}

std::size_t size(Eigen::Index count) { return static_cast<std::size_t>(count); }

RowMatrix compressed(const RowMatrix& matrix, const std::vector<Eigen::Index>& rows) {
  return matrix(rows, Eigen::all);
}

}  // namespace

InteractionModel::InteractionModel(const RowMatrix& samples, const RowMatrix& begins,
                                   const std::optional<RowMatrix>& scene, int partner_dimensions,
                                   const InteractionPrimitiveConfig& with)
    : config(with),
      parameters(samples),
      starts(begins),
      environment(scene),
      S(samples.rows()),
      N(begins.cols()),
      partner(partner_dimensions),
      M(with.dmp.basis_functions),
      lanes(static_cast<Eigen::Index>(padded(size(samples.rows())))) {
  validate(config);
  require(config.noise.has_value(), "noise is not set, must be a variance > 0");
  require_between("number of demonstrations", double(S), 2, 1e4, "demonstrations");
  require_between("partner's dimensions", double(partner), 1, double(N), "");
  require_shape("parameters", parameters, S, D());
  require_shape("starts", starts, S, N);
  set_parameters();
  if (environment) set_environment();
}

void InteractionModel::set_parameters() {
  const Eigen::Index Q = static_cast<Eigen::Index>(response_width(config.dmp));
  const Eigen::RowVectorXd average = parameters.colwise().mean();
  flat = RowMatrix::Zero(S, static_cast<Eigen::Index>(padded(size(D()))));
  flat.leftCols(D()) = (parameters.rowwise() - average) / std::sqrt(double(S));
  means = RowMatrix::Zero(Q, N);
  loadings = RowMatrix::Zero(Q, N * lanes);
  for (Eigen::Index d = 0; d < N; ++d) {
    auto block = loadings.middleCols(d * lanes, S);
    block.topRows(M + 1) = parameters.middleCols(d * (M + 1), M + 1).transpose();
    block.row(M + 1) = starts.col(d).transpose();
    means.col(d) = block.rowwise().mean();                            // 5.8
    block = (block.colwise() - means.col(d)) / std::sqrt(double(S));  // 5.9: Sigma = L L^T
  }
}

void InteractionModel::set_environment() {
  require(environment->cols() > 0, "environment has 0 columns, must have at least 1");
  require_shape("environment", *environment, S, environment->cols());
  const Eigen::RowVectorXd average = environment->colwise().mean();
  const RowMatrix centred = environment->rowwise() - average;
  scale = (centred.colwise().squaredNorm() / double(S)).cwiseSqrt().transpose();
  for (Eigen::Index i = 0; i < scale.size(); ++i)
    require(scale[i] > 1e-12 * (1e-300 + environment->col(i).cwiseAbs().maxCoeff()),
            "environment column " + std::to_string(i) + " is " + std::to_string(average[i]) +
                " in all demonstrations, must vary: leave it out");
  centre = average.transpose().cwiseQuotient(scale);
  reactions = (centred.array().rowwise() / scale.transpose().array()).matrix().transpose() / std::sqrt(double(S));
  if (!config.printed_environment_weights) return;
  // w_e = e theta^+ (after 5.16, ERRATA 42): minimum norm for S < D, least squares without intercept for S > D.
  const RowMatrix scaled = environment->array().rowwise() / scale.transpose().array();
  const Eigen::MatrixXd weights = Eigen::MatrixXd(parameters).completeOrthogonalDecomposition().solve(scaled);
  const Eigen::VectorXd mu = parameters.colwise().mean().transpose();
  centre = weights.transpose() * mu;
  reactions = weights.transpose() * (parameters.transpose().colwise() - mu) / std::sqrt(double(S));
}

Information::Information(const InteractionModel& model)
    : matrix(RowMatrix::Zero(model.lanes, model.lanes)),
      vector(Eigen::VectorXd::Zero(model.lanes)),
      environment_matrix(Eigen::MatrixXd::Zero(model.S, model.S)),
      environment_vector(Eigen::VectorXd::Zero(model.S)) {}

void Information::add_environment(const InteractionModel& model, const Eigen::VectorXd& environment) {
  require(model.environment.has_value(), "environment is given, but the primitive was learned without one");
  require(environment.size() == model.scale.size(), "environment has " + std::to_string(environment.size()) +
                                                        " values, must have " + std::to_string(model.scale.size()));
  for (Eigen::Index i = 0; i < environment.size(); ++i) {
    if (std::isnan(environment[i])) continue;
    require_finite("environment[" + std::to_string(i) + "]", environment[i], "");
    const Eigen::VectorXd reaction = model.reactions.row(i);
    const double surprise = environment[i] / model.scale[i] - model.centre[i];
    environment_matrix += reaction * reaction.transpose() / model.config.environment_noise;
    environment_vector += reaction * (surprise / model.config.environment_noise);
    environment_squares += surprise * surprise / model.config.environment_noise;
    ++environment_count;
  }
}

void Information::add_samples(const InteractionModel& model, const RowMatrix& rows, const RowMatrix& values) {
  if (values.rows() == 0) return;
  if (!values.array().isNaN().any()) return add_group(model, rows, values, 0);
  for (Eigen::Index d = 0; d < values.cols(); ++d) {
    std::vector<Eigen::Index> seen;
    for (Eigen::Index k = 0; k < values.rows(); ++k)
      if (!std::isnan(values(k, d))) seen.push_back(k);
    if (!seen.empty()) add_group(model, compressed(rows, seen), compressed(values.col(d), seen), d);
  }
}

namespace {

/// Columns of the rows that are not 0 to rounding: basis functions are local, and a short observation sees few.
std::vector<Eigen::Index> active_columns(const RowMatrix& rows) {
  constexpr double nothing = 1e-22;
  const Eigen::RowVectorXd largest = rows.cwiseAbs().colwise().maxCoeff();
  std::vector<Eigen::Index> active;
  for (Eigen::Index i = 0; i < rows.cols(); ++i)
    if (largest[i] > nothing) active.push_back(i);
  return active;
}

/// The columns named, then zeros up to a multiple of the lanes.
RowMatrix packed_columns(const RowMatrix& matrix, const std::vector<Eigen::Index>& columns) {
  RowMatrix made = RowMatrix::Zero(matrix.rows(), static_cast<Eigen::Index>(padded(columns.size())));
  for (Eigen::Index k = 0; k < matrix.rows(); ++k)
    for (std::size_t i = 0; i < columns.size(); ++i) made(k, static_cast<Eigen::Index>(i)) = matrix(k, columns[i]);
  return made;
}

RowMatrix packed_rows(const Eigen::Ref<const RowMatrix, 0, Eigen::OuterStride<>>& matrix,
                      const std::vector<Eigen::Index>& rows, std::size_t columns) {
  RowMatrix made = RowMatrix::Zero(static_cast<Eigen::Index>(padded(rows.size())), static_cast<Eigen::Index>(columns));
  for (std::size_t i = 0; i < rows.size(); ++i)
    made.row(static_cast<Eigen::Index>(i)).head(matrix.cols()) = matrix.row(rows[i]);
  return made;
}

}  // namespace

// All degrees of freedom see the same rows R: sum_d B_d^T (R^T R) B_d instead of the Gram matrix of K n rows.
void Information::add_group(const InteractionModel& model, const RowMatrix& rows, const RowMatrix& values,
                            Eigen::Index first) {
  const Eigen::Index n = values.cols();
  const std::size_t lanes = size(model.lanes), columns = size(n) * lanes, n_padded = padded(size(n));
  const std::vector<Eigen::Index> active = active_columns(rows);
  const RowMatrix R = packed_columns(rows, active);
  const RowMatrix B = packed_rows(model.loadings.middleCols(first * model.lanes, n * model.lanes), active, columns);
  const RowMatrix mean = packed_rows(model.means.middleCols(first, n), active, size(n));
  const std::size_t width = size(R.cols());
  RowMatrix gram(R.cols(), R.cols()), spread(R.cols(), static_cast<Eigen::Index>(columns));
  transposed_product({R.data(), width}, {R.data(), width}, gram.data(), size(R.rows()), width, width);
  transposed_product({gram.data(), width}, {B.data(), columns}, spread.data(), width, width, columns);
  RowMatrix surprise = RowMatrix::Zero(R.rows(), static_cast<Eigen::Index>(n_padded));
  surprise.leftCols(n).noalias() = values - R.lazyProduct(mean);
  squares += surprise.squaredNorm();
  count += values.size();
  RowMatrix weighted(R.cols(), static_cast<Eigen::Index>(n_padded));
  transposed_product({R.data(), width}, {surprise.data(), n_padded}, weighted.data(), size(R.rows()), width, n_padded);
  for (Eigen::Index d = 0; d < n; ++d) {
    const std::size_t at = size(d) * lanes;
    add_transposed_product({B.data() + at, columns}, {spread.data() + at, columns}, matrix.data(), width, lanes, lanes);
    vector.noalias() += B.middleCols(d * model.lanes, model.lanes).transpose().lazyProduct(weighted.col(d));
  }
}

void Information::add_sample(const InteractionModel& model, const Eigen::Ref<const Eigen::VectorXd>& row,
                             const Eigen::VectorXd& values) {
  for (Eigen::Index d = 0; d < values.size(); ++d) {
    if (std::isnan(values[d])) continue;
    const auto B = model.loadings.block(0, d * model.lanes, row.size(), model.lanes);
    const Eigen::VectorXd reaction = B.transpose() * row;
    const double surprise = values[d] - row.dot(model.means.col(d).head(row.size()));
    matrix.noalias() += reaction * reaction.transpose();
    vector += reaction * surprise;
    squares += surprise * surprise;
    ++count;
  }
}

RowMatrix observation_rows(const InteractionPrimitiveConfig& config, const Eigen::VectorXd& time) {
  const Eigen::Index M = config.dmp.basis_functions;
  if (config.observe == Observed::forcing) {  // 5.13
    const BasisTable table(config.dmp);
    RowMatrix rows = RowMatrix::Zero(time.size(), static_cast<Eigen::Index>(padded(size(M) + 1)));
    for (Eigen::Index k = 0; k < time.size(); ++k) table.row_at(time[k], rows.row(k).data());
    rows.col(M).setConstant(config.dmp.stiffness * config.dmp.damping);
    return rows;
  }
  ResponseWalk walk(config.dmp);
  RowMatrix rows(time.size(), static_cast<Eigen::Index>(response_width(config.dmp)));
  for (Eigen::Index k = 0; k < time.size(); ++k) {
    walk.advance_to(time[k]);
    rows.row(k) = Eigen::Map<const Eigen::RowVectorXd>(walk.positions().data(), rows.cols());
  }
  return rows;
}

double observation_time(const DmpConfig& config, double phase) {
  const double last = std::exp(-config.phase_decay);
  require_between("phase", phase, last * (1 - 1e-9), 1, "(the last is the motion's end)");
  return -std::log(phase) / config.phase_decay;
}

}  // namespace lfdcore::detail
