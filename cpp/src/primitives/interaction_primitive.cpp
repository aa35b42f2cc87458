#include "lfdcore/primitives/interaction_primitive.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <numbers>
#include <random>
#include <string>

#include "differences.hpp"
#include "interaction_model.hpp"
#include "lfdcore/error.hpp"
#include "small_products.hpp"

namespace lfdcore {

using detail::InteractionModel;

void validate(const InteractionPrimitiveConfig& config) {
  validate(config.dmp);
  if (config.noise) require_positive("noise", *config.noise, "(a variance)");
  require_positive("environment_noise", config.environment_noise, "(a variance)");
}

namespace {

struct Demonstration {
  Eigen::VectorXd parameters, start;
  double squares = 0, power = 0;  // of the partner's residuals and values
  Eigen::Index values = 0;
};

// theta of one demonstration: w_1, g_1, w_2, ... (5.6)
Eigen::VectorXd flattened(const Dmp& dmp) {
  RowMatrix both(dmp.dimensions(), dmp.config().basis_functions + 1);
  both << dmp.weights(), dmp.goal();
  return both.reshaped<Eigen::RowMajor>();
}

RowMatrix residuals(const Dmp& dmp, const RowMatrix& positions, Observed observe) {
  const int steps = static_cast<int>(positions.rows());
  if (observe == Observed::positions) return positions - dmp.rollout(steps).positions;
  return forcing_terms(positions, dmp.goal(), dmp.config()) -
         basis(phases(steps, dmp.config()), dmp.config()) * dmp.weights().transpose();
}

double observed_power(const Dmp& dmp, const RowMatrix& positions, Observed observe) {
  const double k = observe == Observed::positions ? 1 : dmp.config().stiffness * dmp.config().damping;
  return k * k * positions.squaredNorm();
}

Demonstration fitted(const RowMatrix& partner, const RowMatrix& robot, const InteractionPrimitiveConfig& config) {
  RowMatrix both(partner.rows(), partner.cols() + robot.cols());
  both << partner, robot;
  const Dmp dmp = Dmp::fit(both, config.dmp, config.observe);
  const RowMatrix rest = residuals(dmp, both, config.observe).leftCols(partner.cols());
  return {flattened(dmp), dmp.start(), rest.squaredNorm(), observed_power(dmp, partner, config.observe), rest.size()};
}

void require_demonstrations(const std::vector<RowMatrix>& partner, const std::vector<RowMatrix>& robot) {
  require_between("number of demonstrations", double(partner.size()), 2, 1e4, "demonstrations");
  require(partner.size() == robot.size(), std::to_string(partner.size()) + " motions of the partner, but " +
                                              std::to_string(robot.size()) + " of the robot");
  for (std::size_t j = 0; j < partner.size(); ++j) {
    const std::string which = "demonstration " + std::to_string(j);
    require(partner[j].rows() == robot[j].rows(), which + " has " + std::to_string(partner[j].rows()) +
                                                      " samples of the partner, but " +
                                                      std::to_string(robot[j].rows()) + " of the robot");
    require(partner[j].cols() == partner[0].cols() && robot[j].cols() == robot[0].cols(),
            which + " has " + std::to_string(partner[j].cols()) + " + " + std::to_string(robot[j].cols()) +
                " dimensions, must have " + std::to_string(partner[0].cols()) + " + " +
                std::to_string(robot[0].cols()) + " as the first");
  }
}

// The residual, but never so small that information overflows where the basis fits exactly.
double pooled_noise(double squares, double power, Eigen::Index values) {
  return std::max({squares, 1e-10 * power, 1e-12}) / double(std::max<Eigen::Index>(values, 1));
}

}  // namespace

InteractionPrimitive::InteractionPrimitive(const RowMatrix& parameters, const RowMatrix& starts,
                                           const std::optional<RowMatrix>& environment, int partner,
                                           const InteractionPrimitiveConfig& config)
    : model_(std::make_shared<const InteractionModel>(parameters, starts, environment, partner, config)) {}

InteractionPrimitive InteractionPrimitive::fit(const std::vector<RowMatrix>& partner,
                                               const std::vector<RowMatrix>& robot,
                                               const std::optional<RowMatrix>& environment,
                                               const InteractionPrimitiveConfig& config) {
  validate(config);
  require_demonstrations(partner, robot);
  const Eigen::Index S = static_cast<Eigen::Index>(partner.size()), N = partner[0].cols() + robot[0].cols();
  RowMatrix parameters(S, N * (config.dmp.basis_functions + 1)), starts(S, N);
  double squares = 0, power = 0;
  Eigen::Index values = 0;
  for (Eigen::Index j = 0; j < S; ++j) {
    const std::size_t at = static_cast<std::size_t>(j);
    const Demonstration made = fitted(partner[at], robot[at], config);
    parameters.row(j) = made.parameters;
    starts.row(j) = made.start;
    squares += made.squares, power += made.power, values += made.values;
  }
  InteractionPrimitiveConfig with = config;
  if (!with.noise) with.noise = pooled_noise(squares, power, values);
  return InteractionPrimitive(parameters, starts, environment, static_cast<int>(partner[0].cols()), with);
}

const RowMatrix& InteractionPrimitive::parameters() const { return model_->parameters; }
const RowMatrix& InteractionPrimitive::starts() const { return model_->starts; }
const std::optional<RowMatrix>& InteractionPrimitive::environment() const { return model_->environment; }
int InteractionPrimitive::partner_dimensions() const { return static_cast<int>(model_->partner); }
int InteractionPrimitive::robot_dimensions() const { return static_cast<int>(model_->N - model_->partner); }
const InteractionPrimitiveConfig& InteractionPrimitive::config() const { return model_->config; }

namespace {

[[noreturn]] void refuse_phase(Eigen::Index k, double phase) {
  throw std::invalid_argument("phase[" + std::to_string(k) + "] is " + std::to_string(phase) +
                              ", must be below the one before");
}

// Normalised times of falling phases.
Eigen::VectorXd rising_times(const Eigen::VectorXd& phase, Eigen::Index samples, const DmpConfig& config) {
  require(phase.size() == samples,
          std::to_string(samples) + " samples of the partner, but " + std::to_string(phase.size()) + " phases");
  Eigen::VectorXd time(samples);
  for (Eigen::Index k = 0; k < samples; ++k) {
    time[k] = detail::observation_time(config, phase[k]);
    if (k > 0 && !(time[k] > time[k - 1])) refuse_phase(k, phase[k]);
  }
  return time;
}

void require_seen(const RowMatrix& partner) {
  constexpr double most = 1e9;
  for (Eigen::Index k = 0; k < partner.rows(); ++k)
    for (Eigen::Index d = 0; d < partner.cols(); ++d)
      if (std::abs(partner(k, d)) > most)
        require_between("partner[" + std::to_string(k) + ", " + std::to_string(d) + "]", partner(k, d), -most, most,
                        "");
}

constexpr double unseen = std::numeric_limits<double>::quiet_NaN();

// Each run of samples without a gap has derivatives of its own.
void set_forcing(RowMatrix& forcing, const RowMatrix& positions, const Eigen::VectorXd& time, Eigen::Index d,
                 const DmpConfig& config) {
  const Eigen::Index K = positions.rows();
  for (Eigen::Index first = 0; first < K; ++first) {
    Eigen::Index count = 0;
    while (first + count < K && !std::isnan(positions(first + count, d))) ++count;
    if (count >= 3)
      forcing.col(d).segment(first, count) =
          detail::observed_forcing(positions.col(d).segment(first, count), time.segment(first, count), config);
    first += count;
  }
}

RowMatrix forcing_at(const RowMatrix& positions, const Eigen::VectorXd& time, const DmpConfig& config) {
  if (positions.rows() >= 3 && !positions.array().isNaN().any())
    return detail::observed_forcing(positions, time, config);
  RowMatrix forcing = RowMatrix::Constant(positions.rows(), positions.cols(), unseen);
  for (Eigen::Index d = 0; d < positions.cols(); ++d) set_forcing(forcing, positions, time, d, config);
  return forcing;
}

}  // namespace

RowMatrix partner_forcing(const RowMatrix& positions, const Eigen::VectorXd& phase, const DmpConfig& config) {
  validate(config);
  require_seen(positions);
  return forcing_at(positions, rising_times(phase, positions.rows(), config), config);
}

InteractionPosterior InteractionPrimitive::condition(const RowMatrix& partner, const Eigen::VectorXd& phase,
                                                     const std::optional<Eigen::VectorXd>& environment) const {
  const InteractionModel& model = *model_;
  require(partner.rows() == 0 || partner.cols() == model.partner,
          "partner has " + std::to_string(partner.cols()) + " dimensions, must have " + std::to_string(model.partner));
  require_seen(partner);
  const Eigen::VectorXd time = rising_times(phase, partner.rows(), model.config.dmp);
  detail::Information seen(model);
  const bool forcing = model.config.observe == Observed::forcing;
  if (partner.rows() > 0)
    seen.add_samples(model, detail::observation_rows(model.config, time),
                     forcing ? forcing_at(partner, time, model.config.dmp) : partner);
  if (environment) seen.add_environment(model, *environment);
  return InteractionPosterior(model_, seen);
}

InteractionObserver InteractionPrimitive::begin(const std::optional<Eigen::VectorXd>& environment) const {
  return InteractionObserver(model_, environment);
}

struct InteractionObserver::State {
  std::shared_ptr<const InteractionModel> model;
  detail::Information seen;
  detail::ResponseWalk walk;

  Eigen::VectorXd row_at(double time);
};

InteractionObserver::InteractionObserver(std::shared_ptr<const InteractionModel> model,
                                         const std::optional<Eigen::VectorXd>& environment)
    : state_(
          std::make_unique<State>(State{model, detail::Information(*model), detail::ResponseWalk(model->config.dmp)})) {
  if (environment) state_->seen.add_environment(*model, *environment);
}

InteractionObserver::InteractionObserver(InteractionObserver&&) noexcept = default;
InteractionObserver::~InteractionObserver() = default;

Eigen::VectorXd InteractionObserver::State::row_at(double time) {
  if (model->config.observe == Observed::forcing)
    return detail::observation_rows(model->config, Eigen::VectorXd::Constant(1, time)).row(0);
  if (time < walk.time()) walk = detail::ResponseWalk(model->config.dmp);
  walk.advance_to(time);
  return Eigen::Map<const Eigen::VectorXd>(walk.positions().data(), model->means.rows());
}

void InteractionObserver::observe(double phase, const Eigen::VectorXd& values) {
  const InteractionModel& model = *state_->model;
  require(values.size() == model.partner,
          "values has " + std::to_string(values.size()) + " values, must have " + std::to_string(model.partner));
  for (const double value : values) require(!std::isinf(value), "values must be finite, or NaN where not seen");
  state_->seen.add_sample(model, state_->row_at(detail::observation_time(model.config.dmp, phase)), values);
}

InteractionPosterior InteractionObserver::posterior() const {
  return InteractionPosterior(state_->model, state_->seen);
}

// C = (I + L^T O^T R^-1 O L)^-1 (ERRATA 40), 5.15 without a matrix of size D.
InteractionPosterior::InteractionPosterior(std::shared_ptr<const InteractionModel> model,
                                           const detail::Information& seen)
    : model_(std::move(model)) {
  const Eigen::Index S = model_->S;
  const double noise = *model_->config.noise;
  Eigen::MatrixXd precision = seen.environment_matrix + seen.matrix.topLeftCorner(S, S) / noise;
  precision.diagonal().array() += 1;
  const Eigen::LLT<Eigen::MatrixXd> factor(precision);
  const Eigen::VectorXd surprise = seen.environment_vector + seen.vector.head(S) / noise;
  latent_ = factor.solve(surprise);
  spread_ = factor.matrixU().solve(Eigen::MatrixXd::Identity(S, S));
  const double squares = seen.squares / noise + seen.environment_squares - surprise.dot(latent_);
  const double widths =
      double(seen.count) * std::log(2 * std::numbers::pi * noise) +
      double(seen.environment_count) * std::log(2 * std::numbers::pi * model_->config.environment_noise);
  const double volume = 2 * Eigen::MatrixXd(factor.matrixL()).diagonal().array().log().sum();
  log_likelihood_ = -0.5 * (squares + widths + volume);
}

Dmp InteractionPosterior::motion(Eigen::Index first, Eigen::Index count) const {
  const Eigen::Index M = model_->M;
  Eigen::VectorXd start(count), goal(count);
  RowMatrix weights(count, M);
  for (Eigen::Index d = 0; d < count; ++d) {
    const Eigen::VectorXd all = model_->means.col(first + d) + model_->loading(first + d) * latent_;
    weights.row(d) = all.head(M);
    goal[d] = all[M];
    start[d] = all[M + 1];
  }
  return Dmp(start, goal, weights, model_->config.dmp);
}

Dmp InteractionPosterior::robot() const {
  require(model_->N > model_->partner, "the primitive has no robot: 0 dimensions");
  return motion(model_->partner, model_->N - model_->partner);
}

Dmp InteractionPosterior::partner() const { return motion(0, model_->partner); }
Eigen::VectorXd InteractionPosterior::mean() const {
  Eigen::VectorXd all = model_->parameters.colwise().mean().transpose();
  all.noalias() += model_->flat.topLeftCorner(model_->S, model_->D()).transpose() * latent_;
  return all;
}

Eigen::VectorXd InteractionPosterior::start() const { return motion(0, model_->N).start(); }
double InteractionPosterior::trace() const { return factor().squaredNorm(); }

Eigen::MatrixXd InteractionPosterior::factor() const {
  const Eigen::Index width = model_->flat.cols(), lanes = model_->lanes;
  RowMatrix spread = RowMatrix::Zero(model_->S, lanes), all(lanes, width);
  spread.leftCols(model_->S) = spread_;
  const auto size = [](Eigen::Index count) { return static_cast<std::size_t>(count); };
  detail::transposed_product({spread.data(), size(lanes)}, {model_->flat.data(), size(width)}, all.data(),
                             size(model_->S), size(lanes), size(width));
  return all.topLeftCorner(model_->S, model_->D()).transpose();
}

namespace {

Eigen::MatrixXd whole_motion(const InteractionModel& model, int steps) {
  require_between("steps", steps, 2, 1e6, "samples");
  return detail::response(model.config.dmp, steps, 0, 1)->transposed.leftCols(steps).transpose();
}

Eigen::MatrixXd draws(Eigen::Index rows, int count, std::uint64_t seed) {
  require_between("count", count, 1, 1e6, "samples");
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(rows, count, [&] { return normal(generator); });
}

}  // namespace

InteractionTrajectory InteractionPosterior::trajectory(int steps) const {
  const Eigen::MatrixXd H = whole_motion(*model_, steps);
  const Eigen::Index N = model_->N, S = model_->S;
  InteractionTrajectory made{Eigen::MatrixXd(steps, N), RowMatrix(steps, N * N)};
  std::vector<RowMatrix> parts;
  for (Eigen::Index d = 0; d < N; ++d) {
    made.mean.col(d) = H * (model_->means.col(d) + model_->loading(d) * latent_);
    const Eigen::MatrixXd loaded = model_->loading(d) * spread_;
    parts.emplace_back(H * loaded);
  }
  RowMatrix here(N, S);
  for (Eigen::Index k = 0; k < steps; ++k) {
    for (Eigen::Index d = 0; d < N; ++d) here.row(d) = parts[static_cast<std::size_t>(d)].row(k);
    Eigen::Map<RowMatrix>(made.covariance.row(k).data(), N, N).noalias() = here * here.transpose();
  }
  return made;
}

RowMatrix InteractionPosterior::sample(int count, std::uint64_t seed) const {
  const Eigen::MatrixXd z = draws(model_->S, count, seed);
  return (factor() * z).transpose().rowwise() + mean().transpose();
}

std::vector<RowMatrix> InteractionPosterior::sample_trajectories(int count, int steps, std::uint64_t seed) const {
  const Eigen::MatrixXd H = whole_motion(*model_, steps);
  const Eigen::MatrixXd z = (spread_ * draws(model_->S, count, seed)).colwise() + latent_;
  std::vector<RowMatrix> made(static_cast<std::size_t>(count), RowMatrix(steps, model_->N));
  for (Eigen::Index d = 0; d < model_->N; ++d) {
    const Eigen::MatrixXd motions = H * ((model_->loading(d) * z).colwise() + model_->means.col(d));
    for (Eigen::Index i = 0; i < count; ++i) made[static_cast<std::size_t>(i)].col(d) = motions.col(i);
  }
  return made;
}

}  // namespace lfdcore
