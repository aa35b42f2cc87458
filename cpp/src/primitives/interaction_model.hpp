// What the demonstrations say: mean and loadings of the parameters, and the information that observations add.
#pragma once

#include <optional>
#include <vector>

#include "lfdcore/primitives/interaction_primitive.hpp"
#include "response.hpp"

namespace lfdcore::detail {

/// theta = mu + L z, z ~ N(0, I_S) (ERRATA 40), extended by the starts: of each degree of freedom w (M), g, y0, padded
/// with zeros to Q rows as a response is.
struct InteractionModel {
  InteractionPrimitiveConfig config;
  RowMatrix parameters, starts;
  std::optional<RowMatrix> environment;
  Eigen::Index S, N, partner, M;
  Eigen::Index lanes;         ///< S padded
  RowMatrix means;            ///< (Q, N)
  RowMatrix loadings;         ///< (Q, N lanes): L of degree of freedom d in columns d lanes ...
  RowMatrix flat;             ///< (S, D padded): L^T
  Eigen::VectorXd scale;      ///< (E,) standard deviations
  Eigen::VectorXd centre;     ///< (E,) what the model expects of e / scale
  Eigen::MatrixXd reactions;  ///< (E, S): d (e / scale) / dz

  InteractionModel(const RowMatrix& parameters, const RowMatrix& starts, const std::optional<RowMatrix>& environment,
                   int partner, const InteractionPrimitiveConfig& config);

  Eigen::Index D() const { return N * (M + 1); }
  auto loading(Eigen::Index d) const { return loadings.middleCols(d * lanes, S); }

 private:
  void set_parameters();
  void set_environment();
};

/// Of z: precision I + matrix, matrix * mean = vector.
struct Information {
  RowMatrix matrix;        ///< (lanes, lanes), the partner's times sigma^2
  Eigen::VectorXd vector;  ///< (lanes,)
  double squares = 0;      ///< of what the partner's values differ from the mean by
  Eigen::Index count = 0;  ///< of those values
  Eigen::MatrixXd environment_matrix;
  Eigen::VectorXd environment_vector;
  double environment_squares = 0;  ///< over sigma_e^2
  Eigen::Index environment_count = 0;

  explicit Information(const InteractionModel& model);
  void add_environment(const InteractionModel& model, const Eigen::VectorXd& environment);
  /// Rows (K, width) of responses and the partner's values (K, n), NaN: not seen.
  void add_samples(const InteractionModel& model, const RowMatrix& rows, const RowMatrix& values);
  void add_sample(const InteractionModel& model, const Eigen::Ref<const Eigen::VectorXd>& row,
                  const Eigen::VectorXd& values);

 private:
  void add_group(const InteractionModel& model, const RowMatrix& rows, const RowMatrix& values, Eigen::Index first);
};

/// Rows (K, width) that map (w, g, y0) to what is observed at normalised times (K,), rising.
RowMatrix observation_rows(const InteractionPrimitiveConfig& config, const Eigen::VectorXd& time);

/// Normalised times of phases in [exp(-alpha_x), 1].
double observation_time(const DmpConfig& config, double phase);

}  // namespace lfdcore::detail
