#include "lfdcore/primitives/open_end_dtw.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "dtw_diagonals.hpp"
#include "lfdcore/error.hpp"
#include "series_checks.hpp"

namespace lfdcore {
namespace {

// row[j] becomes D of the next sample and column j, from D of the last one; the argmin of the new row. `first` is the
// first sample: then row 0 of D is (0, inf, ..).
int advance(const std::vector<double>& distances, bool first, std::vector<double>& row) {
  double left = distances[0] + (first ? 0 : row[0]), above_left = row[0];
  row[0] = left;
  int best = 0;
  for (std::size_t j = 1; j < row.size(); ++j) {
    const double above = row[j], reached = first ? left : std::min(std::min(above, above_left), left);
    above_left = above;
    row[j] = left = distances[j] + reached;
    if (left < row[static_cast<std::size_t>(best)]) best = static_cast<int>(j);
  }
  return best;
}

}  // namespace

OpenEndDtw::OpenEndDtw(const RowMatrix& reference)
    : count_(static_cast<int>(reference.rows())),
      dimensions_(static_cast<int>(reference.cols())),
      reference_(reference.size()),
      row_(static_cast<std::size_t>(count_)),
      distances_(static_cast<std::size_t>(count_)),
      seen_(static_cast<std::size_t>(dimensions_)) {
  detail::require_series("reference", reference);
  Eigen::Map<RowMatrix>(reference_.data(), reference.cols(), reference.rows()) = reference.transpose();
}

OpenEndPhase OpenEndDtw::observe(std::span<const double> sample) {
  if (static_cast<int>(sample.size()) != dimensions_)
    throw std::invalid_argument("sample has " + std::to_string(sample.size()) + " dimensions, the reference " +
                                std::to_string(dimensions_));
  detail::require_sample(sample.data(), dimensions_);
  int seen = 0;
  for (std::size_t d = 0; d < sample.size(); ++d) seen += seen_[d] = !std::isnan(sample[d]);
  if (seen == 0) return phase_;
  detail::distances_to(reference_.data(), count_, dimensions_, sample.data(), seen_.data(), distances_.data());
  if (seen < dimensions_)
    for (double& distance : distances_) distance *= std::sqrt(double{1} * dimensions_ / seen);
  phase_.index = advance(distances_, phase_.index < 0, row_);
  phase_.distance = row_[static_cast<std::size_t>(phase_.index)];
  return phase_;
}

void OpenEndDtw::reset() { phase_ = {}; }

OpenEndPhase open_end_dtw(const RowMatrix& query, const RowMatrix& reference) {
  OpenEndDtw dtw(reference);
  require(query.rows() > 0, "query is empty, must have a sample at least");
  for (Eigen::Index t = 0; t < query.rows(); ++t)
    dtw.observe({query.row(t).data(), static_cast<std::size_t>(query.cols())});
  return dtw.phase();
}

}  // namespace lfdcore
