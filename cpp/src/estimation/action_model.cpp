#include "lfdcore/estimation/action_model.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <string>

#include "action_output.hpp"
#include "action_sums.hpp"
#include "lfdcore/error.hpp"

namespace lfdcore {

using detail::ActionOutput;
using detail::block_size;
using detail::lanes;
using detail::PairTerms;
using Eigen::Index;

namespace {

// What blocks of samples left out of the trace may change it by, as a share of s^2 (G_aa is at least s^2).
constexpr double negligible = 1e-12;

// Sums over pairs of goals cost L^2 N, those over pairs of samples some 15 N^2.
int worth_sharing(Index goals, Index samples) { return goals * goals <= 8 * samples ? static_cast<int>(goals) : 0; }

std::size_t padded(Index count) { return std::size_t(detail::blocks_of(count)) * lanes; }

GoalVector squared(const Eigen::VectorXd& lengthscales) { return lengthscales.array().square(); }

// The next doubles of a scratch.
struct Arena {
  std::span<double> left;
  double* take(std::size_t count) {
    double* taken = left.data();
    left = left.subspan(count);
    return taken;
  }
};

// The Gaussian of q_ai over the goal: w(g) = a^2 det(Sigma H^-1 + I)^-1/2 exp(-(mu - g)'(Sigma + H)^-1 (mu - g) / 2)
struct GoalGaussian {
  Eigen::LLT<GoalMatrix> factor;
  double scale;

  GoalGaussian(const GoalMatrix& covariance, const GoalVector& H, double amplitude) {
    GoalMatrix sum = covariance;
    sum.diagonal() += H;
    factor.compute(sum);
    scale = amplitude * amplitude * std::sqrt(H.prod()) / factor.matrixLLT().diagonal().prod();
  }
  double operator()(const GoalVector& offset) const {
    GoalVector whitened = offset;
    factor.matrixL().solveInPlace(whitened);
    return scale * std::exp(-0.5 * whitened.squaredNorm());
  }
};

// W_ij of Q_ab,ij = scale k_i k_j W_ij, expanded about u = g - mu: with S = (Ha + Hb)^-1, B = Hb S, A = Ha S and R,
// log W = -(u_i - u_j)'S(u_i - u_j) / 2 - (B u_i + A u_j)'R^-1 (B u_i + A u_j) / 2
//       = left(u_i) + right(u_j) + (slopes u_i)'u_j
struct GoalPair {
  GoalMatrix left, right, slopes;
  double scale;

  GoalPair(const GoalMatrix& covariance, const GoalVector& Ha, const GoalVector& Hb, double amplitudes) {
    const GoalVector S = (Ha + Hb).cwiseInverse(), A = Ha.cwiseProduct(S), B = Hb.cwiseProduct(S);
    const GoalVector harmonic = Ha.cwiseProduct(B);  // (Ha^-1 + Hb^-1)^-1
    GoalMatrix R = covariance;
    R.diagonal() += harmonic;
    const Eigen::LLT<GoalMatrix> factor(R);
    const GoalMatrix inverse = factor.solve(GoalMatrix::Identity(R.rows(), R.cols()));
    left = -0.5 * (B.asDiagonal() * inverse * B.asDiagonal());
    right = -0.5 * (A.asDiagonal() * inverse * A.asDiagonal());
    slopes = -1.0 * (A.asDiagonal() * inverse * B.asDiagonal());
    left.diagonal() -= 0.5 * S;
    right.diagonal() -= 0.5 * S;
    slopes.diagonal() += S;
    scale = amplitudes * std::sqrt(harmonic.prod()) / factor.matrixLLT().diagonal().prod();
  }
};

// Where an action's sums run: over its samples, or over goals that samples share. Padded to blocks of 32.
struct Points {
  std::size_t count, padded;
  int dims;
  const double* offsets;  // u = g - mu: values[d * padded + i]
  const double* values;   // beta_i k_i, or its sum over the goal's samples; 0 in the padding

  GoalVector at(std::size_t i) const {
    GoalVector u(dims);
    for (int d = 0; d < dims; ++d) u(d) = offsets[std::size_t(d) * padded + i];
    return u;
  }
};

const double* offsets(const std::vector<double>& goals, std::size_t padded, const GoalVector& mean, Arena& arena) {
  double* values = arena.take(padded * static_cast<std::size_t>(mean.size()));
  for (Index d = 0; d < mean.size(); ++d)
    for (std::size_t i = 0; i < padded; ++i) {
      const std::size_t at = static_cast<std::size_t>(d) * padded + i;
      values[at] = goals[at] - mean(d);
    }
  return values;
}

PairTerms pair_terms(const GoalPair& pair, const Points& rows, const Points& columns, Arena& arena) {
  double* left = arena.take(rows.padded);
  double* slopes = arena.take(rows.padded * rows.dims);
  double* right = arena.take(columns.padded);
  for (std::size_t i = 0; i < rows.padded; ++i) {
    const GoalVector u = rows.at(i), slope = pair.slopes * u;
    left[i] = u.dot(pair.left * u);
    for (int d = 0; d < rows.dims; ++d) slopes[std::size_t(d) * rows.padded + i] = slope(d);
  }
  for (std::size_t j = 0; j < columns.padded; ++j) {
    const GoalVector u = columns.at(j);
    right[j] = u.dot(pair.right * u);
  }
  return {left, slopes, rows.padded, right, columns.offsets, columns.padded, rows.dims};
}

// What one action brings to the moments at a state.
struct Terms {
  const double* similarity;  // k_i = exp(-|x - x_i|^2 / 2) over its samples, 0 in the padding
  Points points;
};

}  // namespace

struct ActionModel::Conditioned {
  std::vector<ActionKernel> kernels;
  Index size = 0;
  int state_dims = 0, goal_dims = 0, shared = 0;
  std::vector<double> goals;  // the shared ones: (Dg, 32 blocks)
  detail::BlockKernels blocks = detail::block_kernels_of_this_cpu().back();
  std::vector<ActionOutput> outputs;

  std::size_t scratch() const;
  const double* similarity(int a, std::span<const double> state, Arena& arena) const;
  const double* values(int a, const double* similarity, Arena& arena) const;
  void first_moments(int a, const Terms& terms, const Belief& belief, ActionMoments& moments) const;
  double second_moment(int a, int b, const Terms& first, const Terms& second, const Belief& belief, Arena arena) const;
  double shared_trace(int a, const Terms& terms, const PairTerms& pair, double scale, Arena arena) const;
  detail::PairSums own_goals(int a, const Terms& terms, const PairTerms& pair) const;
};

std::size_t ActionModel::Conditioned::scratch() const {
  std::size_t total = 0, largest = goals.size();
  for (const ActionOutput& output : outputs) {
    total += std::size_t(state_dims) * lanes + 2 * output.padded() + output.goals.size();
    largest = std::max(largest, output.padded());
  }
  const auto L = static_cast<std::size_t>(shared);
  return total + goals.size() * (outputs.size() + 1) + largest * std::size_t(goal_dims + 2) + L * (L + lanes) + largest;
}

const double* ActionModel::Conditioned::similarity(int a, std::span<const double> state, Arena& arena) const {
  const ActionOutput& output = outputs[std::size_t(a)];
  double* query = arena.take(std::size_t(state_dims) * lanes);
  for (int d = 0; d < state_dims; ++d)
    query[d * lanes] = state[std::size_t(d)] / kernels[std::size_t(a)].state_lengthscales(d);
  double* k = arena.take(output.padded());
  for (int block = 0; block < output.blocks; ++block)
    blocks.covariance(KernelFamily::squared_exponential, 1, output.block_inputs(block), query, state_dims, 1,
                      k + std::size_t(block) * lanes, nullptr);
  std::fill(k + output.count, k + output.padded(), 0.0);
  return k;
}

const double* ActionModel::Conditioned::values(int a, const double* k, Arena& arena) const {
  const ActionOutput& output = outputs[std::size_t(a)];
  const double* beta = output.weights.data();
  double* values = arena.take(shared > 0 ? padded(shared) : output.padded());
  if (shared == 0) {
    std::transform(beta, beta + output.padded(), k, values, std::multiplies{});
    return values;
  }
  std::fill_n(values, padded(shared), 0.0);
  for (int c = 0; c < shared; ++c) {
    const Index first = output.starts[std::size_t(c)], last = output.starts[std::size_t(c) + 1];
    values[c] = detail::inner_product(beta + first, k + first, static_cast<std::size_t>(last - first));
  }
  return values;
}

// m_a = sum_i w_i beta_i k_i, C_a = Sigma (Sigma + Ha)^-1 sum_i w_i beta_i k_i (g_i - mu) (ERRATA 4)
void ActionModel::Conditioned::first_moments(int a, const Terms& terms, const Belief& belief,
                                             ActionMoments& moments) const {
  const ActionKernel& kernel = kernels[std::size_t(a)];
  const GoalGaussian gaussian(belief.covariance, squared(kernel.goal_lengthscales), kernel.amplitude);
  double mean = 0;
  GoalVector pull = GoalVector::Zero(goal_dims);
  for (std::size_t i = 0; i < terms.points.count; ++i) {
    const GoalVector u = terms.points.at(i);
    const double q = gaussian(u) * terms.points.values[i];
    mean += q;
    pull += q * u;
  }
  moments.mean(a) = mean;
  moments.cross_covariance.col(a) = belief.covariance * gaussian.factor.solve(pull);
}

// sum over c, c' of W_cc' k_c' D_cc' k_c = sum over the rows z of R of z'Wz, z_c = sum over i in c of R_i k_i. Blocks
// of samples so far from the state that all of them together change it by less than `negligible` are not read.
double ActionModel::Conditioned::shared_trace(int a, const Terms& terms, const PairTerms& pair, double scale,
                                              Arena arena) const {
  const ActionOutput& output = outputs[std::size_t(a)];
  const auto L = static_cast<std::size_t>(shared);
  const double* k = terms.similarity;
  double* W = arena.take(L * L);
  for (std::size_t c = 0; c < L; ++c) detail::pair_column(pair, c, L, W + c * L);
  double* squares = arena.take(static_cast<std::size_t>(output.blocks));
  for (int block = 0; block < output.blocks; ++block)
    squares[block] = detail::inner_product(k + block * lanes, k + block * lanes, lanes);
  const double noise = kernels[std::size_t(a)].noise, all = std::accumulate(squares, squares + output.blocks, 0.0);
  const double cut = negligible * noise * noise / (3 * output.largest_inverse * scale * std::sqrt(all));
  const double cut_square = cut * cut / output.blocks;

  double* z = arena.take(L * lanes);
  double sum = 0;
  for (int row = 0; row < output.blocks; ++row) {
    std::fill_n(z, L * lanes, 0.0);
    const double* panel = output.triangle.block(row, 0);
    const Index end = std::min<Index>((row + 1) * lanes, output.count);
    for (std::size_t c = 0; c < L && output.starts[c] < end; ++c)
      for (Index i = output.starts[c], stop = 0; i < std::min(output.starts[c + 1], end); i = stop) {
        const Index block = i / lanes;
        stop = std::min(output.starts[c + 1], (block + 1) * lanes);
        if (squares[block] > cut_square)
          blocks.accumulate(z + c * lanes, panel + i * lanes, k + i, static_cast<int>(stop - i));
      }
    sum += detail::class_products(z, W, L);
  }
  return sum;
}

// Each sample with its own goal; W and D are symmetric.
detail::PairSums ActionModel::Conditioned::own_goals(int a, const Terms& terms, const PairTerms& pair) const {
  const ActionOutput& output = outputs[std::size_t(a)];
  const double *x = terms.points.values, *k = terms.similarity;
  detail::PairSums sums;
  for (int row = 0; row < output.blocks; ++row) {
    const auto first = std::size_t(row) * lanes;
    const double* panel = output.triangle.block(row, 0);
    const auto left = detail::pair_sums(pair, first, 0, first, x, x, k, panel);
    const auto own = detail::pair_sums(pair, first, first, first + lanes, x, x, k, panel + first * lanes);
    sums.weighted += 2 * left.weighted + own.weighted;
    sums.traced += 2 * left.traced + own.traced;
  }
  return sums;
}

// beta_a'Q_ab beta_b, and for a = b with alpha^2 - Tr(D Q_aa) + s^2 (ERRATA 2)
double ActionModel::Conditioned::second_moment(int a, int b, const Terms& first, const Terms& second,
                                               const Belief& belief, Arena arena) const {
  const ActionKernel &one = kernels[std::size_t(a)], &other = kernels[std::size_t(b)];
  const double variance = one.amplitude * other.amplitude;
  const GoalPair pair(belief.covariance, squared(one.goal_lengthscales), squared(other.goal_lengthscales),
                      variance * variance);
  const PairTerms terms = pair_terms(pair, first.points, second.points, arena);
  const double rest = variance + one.noise * one.noise;
  if (a == b && shared == 0) {
    const auto sums = own_goals(a, first, terms);
    return pair.scale * (sums.weighted - sums.traced) + rest;
  }
  double sum = 0;
  for (std::size_t row = 0; row < first.points.padded; row += lanes)
    sum += detail::pair_sums(terms, row, 0, second.points.count, first.points.values, second.points.values, nullptr,
                             nullptr)
               .weighted;
  if (a != b) return pair.scale * sum;
  return pair.scale * (sum - shared_trace(a, first, terms, pair.scale, arena)) + rest;
}

ActionModel::ActionModel(const RowMatrix& states, const RowMatrix& goals, const RowMatrix& actions,
                         std::vector<ActionKernel> kernels, const std::vector<std::int64_t>* subset, bool projected) {
  detail::check_action_data(states, goals, actions, kernels);
  if (subset) detail::check_subset(*subset, states.rows());
  auto data = std::make_shared<Conditioned>();
  data->kernels = std::move(kernels);
  data->state_dims = static_cast<int>(states.cols());
  data->goal_dims = static_cast<int>(goals.cols());

  std::vector<bool> chosen(static_cast<std::size_t>(states.rows()), subset == nullptr);
  if (subset)
    for (const auto i : *subset) chosen[static_cast<std::size_t>(i)] = true;
  const auto [distinct, number] = detail::shared_goals(goals);
  std::vector<Index> order(static_cast<std::size_t>(states.rows()));
  std::iota(order.begin(), order.end(), Index{0});
  if (!projected) std::erase_if(order, [&](Index i) { return !chosen[static_cast<std::size_t>(i)]; });
  std::ranges::stable_sort(order, {}, [&](Index i) { return number[static_cast<std::size_t>(i)]; });
  data->size = std::ranges::count(chosen, true);
  data->shared = worth_sharing(distinct.rows(), data->size);
  if (data->shared > 0) data->goals = detail::padded_columns(distinct);

  detail::ActionSamples samples{detail::joint_inputs(states, goals, order), {}, {}};
  std::vector<Index> basis;
  for (const Index i : order) {
    if (chosen[static_cast<std::size_t>(i)]) basis.push_back(static_cast<Index>(samples.goals.size()));
    samples.goals.push_back(number[static_cast<std::size_t>(i)]);
  }
  for (int a = 0; a < actions.cols(); ++a) {
    samples.actions = actions.col(a)(order);
    const ActionKernel& kernel = data->kernels[std::size_t(a)];
    data->outputs.push_back(subset && projected ? detail::project(samples, basis, kernel, data->shared)
                                                : detail::condition(samples, kernel, data->shared));
  }
  data_ = std::move(data);
}

ActionMoments ActionModel::moments(std::span<const double> state, const Belief& belief,
                                   std::span<double> scratch) const {
  const Conditioned& data = *data_;
  require(state.size() == static_cast<std::size_t>(data.state_dims),
          "a state must have one value for every state length-scale");
  require(std::ranges::all_of(state, [](double x) { return std::abs(x) <= largest_number; }),
          "the state must be finite and within 1e20");
  require(scratch.size() >= scratch_size(), "the scratch is smaller than scratch_size()");
  validate(belief, data.goal_dims);
  const detail::SubnormalsFlushed flushed;
  Arena arena{scratch};
  const double* common = offsets(data.goals, padded(data.shared), belief.mean, arena);
  std::array<Terms, most_actions> terms;
  const int Da = actions();
  ActionMoments moments{ActionVector(Da), ActionMatrix(Da, Da), CrossMatrix(data.goal_dims, Da)};
  for (int a = 0; a < Da; ++a) {
    const ActionOutput& output = data.outputs[std::size_t(a)];
    const double* k = data.similarity(a, state, arena);
    const double* values = data.values(a, k, arena);
    if (data.shared > 0)
      terms[a] = {k, {static_cast<std::size_t>(data.shared), padded(data.shared), data.goal_dims, common, values}};
    else
      terms[a] = {k,
                  {static_cast<std::size_t>(output.count), output.padded(), data.goal_dims,
                   offsets(output.goals, output.padded(), belief.mean, arena), values}};
    data.first_moments(a, terms[a], belief, moments);
  }
  for (int a = 0; a < Da; ++a)
    for (int b = 0; b <= a; ++b)
      moments.covariance(a, b) = moments.covariance(b, a) =
          data.second_moment(a, b, terms[a], terms[b], belief, arena) - moments.mean(a) * moments.mean(b);
  return moments;
}

std::size_t ActionModel::scratch_size() const { return data_->scratch(); }
Index ActionModel::size() const { return data_->size; }
int ActionModel::state_dimensions() const { return data_->state_dims; }
int ActionModel::goal_dimensions() const { return data_->goal_dims; }
int ActionModel::actions() const { return static_cast<int>(data_->outputs.size()); }
int ActionModel::shared_goals() const { return data_->shared; }
const std::vector<ActionKernel>& ActionModel::kernels() const { return data_->kernels; }

std::size_t ActionModel::nbytes() const {
  std::size_t total = data_->goals.size() * sizeof(double);
  for (const ActionOutput& output : data_->outputs) total += output.bytes();
  return total;
}

}  // namespace lfdcore
