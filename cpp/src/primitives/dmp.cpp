#include "lfdcore/primitives/dmp.hpp"

#include <Eigen/QR>
#include <limits>

#include "differences.hpp"
#include "lfdcore/error.hpp"
#include "response.hpp"
#include "small_products.hpp"

namespace lfdcore {
namespace {

void require_size(const char* name, Eigen::Index size, Eigen::Index wanted) {
  if (size != wanted)
    throw std::invalid_argument(std::string(name) + " has " + std::to_string(size) + " values, must have " +
                                std::to_string(wanted));
}

Eigen::VectorXd checked(const char* name, const std::optional<Eigen::VectorXd>& given,
                        const Eigen::VectorXd& otherwise) {
  if (!given) return otherwise;
  require_size(name, given->size(), otherwise.size());
  require(given->allFinite(), std::string(name) + " must be finite");
  return *given;
}

double normalised_time(const DmpConfig& config, double phase) {
  require_between("phase", phase, std::numeric_limits<double>::min(), 1, "");
  return -std::log(phase) / config.phase_decay;
}

// Of normalised time that a run covers.
double span_of(const DmpRun& run, double begin) {
  if (run.duration) {
    require_positive("duration", *run.duration, "s");
    require_between("duration * rate", *run.duration * run.rate, 0, 1e4, "");
    return *run.duration * run.rate;
  }
  require(begin < 1 - 1e-9, "phase is " + std::to_string(run.phase) +
                                ", at the motion's end or beyond: say the duration [s] of what follows");
  return 1 - begin;
}

}  // namespace

Dmp::Dmp(Eigen::VectorXd start, Eigen::VectorXd goal, RowMatrix weights, const DmpConfig& config)
    : config_(config), start_(std::move(start)), goal_(std::move(goal)), weights_(std::move(weights)) {
  validate(config_);
  require(start_.size() > 0, "start has no values, must have at least 1");
  require_size("goal", goal_.size(), start_.size());
  require_size("weights' rows", weights_.rows(), start_.size());
  require_size("weights' columns", weights_.cols(), config_.basis_functions);
  require(start_.allFinite() && goal_.allFinite() && weights_.allFinite(), "start, goal and weights must be finite");
}

RowMatrix forcing_terms(const RowMatrix& positions, const Eigen::VectorXd& goal, const DmpConfig& config) {
  require_between("number of samples", double(positions.rows()), 3, 1e7, "samples");
  require(positions.cols() > 0, "positions have 0 dimensions, must have at least 1");
  require_size("goal", goal.size(), positions.cols());
  detail::require_positions(positions, "positions");
  const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(positions.rows(), 0, 1);
  const Eigen::MatrixXd forcing = detail::observed_forcing(positions, time, config);
  return forcing.rowwise() - config.stiffness * config.damping * goal.transpose();  // 5.3 = 5.12 less the goal's part
}

namespace {

Dmp fit_forcing(const RowMatrix& positions, const DmpConfig& config) {
  const Eigen::VectorXd goal = positions.row(positions.rows() - 1);
  const RowMatrix forcing = forcing_terms(positions, goal, config);
  const Eigen::MatrixXd phi = basis(phases(static_cast<int>(positions.rows()), config), config);
  return Dmp(positions.row(0), goal, phi.completeOrthogonalDecomposition().solve(forcing).transpose(), config);  // 5.4
}

// The motion is linear in (w, g, y0). Late weights hardly move it: what is below the threshold stays 0.
Dmp fit_motion(const RowMatrix& positions, const DmpConfig& config) {
  constexpr double threshold = 1e-6;
  const int steps = static_cast<int>(positions.rows());
  const Eigen::Index M = config.basis_functions;
  const Eigen::MatrixXd H = detail::response(config, steps, 0, 1)->transposed.topLeftCorner(M + 2, steps).transpose();
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition(H.rows(), H.cols());
  decomposition.setThreshold(threshold);
  decomposition.compute(H);
  const Eigen::MatrixXd found = decomposition.solve(positions);
  return Dmp(found.row(M + 1), found.row(M), found.topRows(M).transpose(), config);
}

}  // namespace

Dmp Dmp::fit(const RowMatrix& positions, const DmpConfig& config, Observed by) {
  validate(config);
  require_between("number of samples", double(positions.rows()), 3, 1e6, "samples");
  require(positions.cols() > 0, "positions have 0 dimensions, must have at least 1");
  detail::require_positions(positions, "positions");
  return by == Observed::forcing ? fit_forcing(positions, config) : fit_motion(positions, config);
}

DmpTrajectory Dmp::rollout(int steps, const DmpRun& run) const {
  require_between("steps", steps, 2, 1e6, "samples");
  require_positive("rate", run.rate, "1/s");
  const double begin = normalised_time(config_, run.phase), span = span_of(run, begin);
  const auto all = detail::response(config_, steps, begin, span);
  const Eigen::Index columns = all->transposed.cols(), group = columns / 3, M = config_.basis_functions;
  const Eigen::Index D = dimensions(), lanes = static_cast<Eigen::Index>(detail::padded(static_cast<std::size_t>(D)));
  RowMatrix parameters = RowMatrix::Zero(all->transposed.rows(), lanes);
  parameters.topLeftCorner(M, D) = weights_.transpose();
  parameters.row(M).head(D) = goal_;
  parameters.row(M + 1).head(D) = checked("position", run.position, start_);
  parameters.row(M + 2).head(D) = checked("velocity", run.velocity, Eigen::VectorXd::Zero(D)) / run.rate;
  RowMatrix samples(lanes, columns);
  detail::transposed_product({parameters.data(), static_cast<std::size_t>(lanes)},
                             {all->transposed.data(), static_cast<std::size_t>(columns)}, samples.data(),
                             static_cast<std::size_t>(parameters.rows()), static_cast<std::size_t>(lanes),
                             static_cast<std::size_t>(columns));
  return {Eigen::VectorXd::LinSpaced(steps, 0, span / run.rate), samples.topRows(D).leftCols(steps).transpose(),
          samples.topRows(D).middleCols(group, steps).transpose() * run.rate,
          samples.topRows(D).middleCols(2 * group, steps).transpose() * (run.rate * run.rate)};
}

DmpStepper Dmp::begin(const DmpRun& run) const { return DmpStepper(*this, run); }

struct DmpStepper::State {
  detail::BasisTable table;
  RowMatrix weights;
  Eigen::VectorXd position, velocity, goal;
  double rate, time;  // normalised time
  Eigen::VectorXd basis, forcing, offset;

  void advance(const detail::ForcedStep& step);
};

DmpStepper::DmpStepper(const Dmp& dmp, const DmpRun& run) {
  require_positive("rate", run.rate, "1/s");
  const Eigen::Index D = dmp.dimensions();
  detail::BasisTable table(dmp.config());
  const Eigen::Index width = static_cast<Eigen::Index>(table.width());
  RowMatrix weights = RowMatrix::Zero(D, width);
  weights.leftCols(dmp.config().basis_functions) = dmp.weights();
  state_ = std::make_unique<State>(
      State{std::move(table), std::move(weights), checked("position", run.position, dmp.start()),
            checked("velocity", run.velocity, Eigen::VectorXd::Zero(D)), dmp.goal(), run.rate,
            normalised_time(dmp.config(), run.phase), Eigen::VectorXd(width), Eigen::VectorXd(D), Eigen::VectorXd(D)});
}

DmpStepper::DmpStepper(DmpStepper&&) noexcept = default;
DmpStepper::~DmpStepper() = default;

void DmpStepper::State::advance(const detail::ForcedStep& step) {
  offset = position - goal;
  position = goal + step.free.yy * offset + step.free.yv / rate * velocity;
  velocity = rate * step.free.vy * offset + step.free.vv * velocity;
  for (int node = 0; node < detail::ForcedStep::nodes; ++node) {
    table.row_at(time + step.at[node], basis.data());
    forcing.noalias() = weights.lazyProduct(basis);
    position += step.position[node] * forcing;
    velocity += rate * step.velocity[node] * forcing;
  }
  time += step.duration;
}

void DmpStepper::step(double dt) {
  State& s = *state_;
  require_between("dt", dt, 0, 1e4 / s.rate, "s");
  if (dt == 0) return;
  const int count = detail::steps_within(s.table.config(), dt * s.rate);
  const detail::ForcedStep step(s.table.config(), dt * s.rate / count);
  for (int i = 0; i < count; ++i) s.advance(step);
}

void DmpStepper::set_goal(const Eigen::VectorXd& goal) {
  require_size("goal", goal.size(), state_->goal.size());
  require(goal.allFinite(), "goal must be finite");
  state_->goal = goal;
}

void DmpStepper::set_rate(double rate) {
  require_positive("rate", rate, "1/s");
  state_->rate = rate;
}

const Eigen::VectorXd& DmpStepper::position() const { return state_->position; }
const Eigen::VectorXd& DmpStepper::velocity() const { return state_->velocity; }
const Eigen::VectorXd& DmpStepper::goal() const { return state_->goal; }
double DmpStepper::rate() const { return state_->rate; }
double DmpStepper::phase() const { return std::exp(-state_->table.config().phase_decay * state_->time); }

}  // namespace lfdcore
