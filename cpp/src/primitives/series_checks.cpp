#include "series_checks.hpp"

#include <cmath>
#include <limits>

#include "lfdcore/error.hpp"

namespace lfdcore::detail {

void require_series(const std::string& name, const RowMatrix& series) {
  require(series.size() > 0, name + " has shape (" + std::to_string(series.rows()) + ", " +
                                 std::to_string(series.cols()) + "), must have a sample and a dimension at least");
  require(series.rows() < std::numeric_limits<int>::max() / 8,
          name + " has " + std::to_string(series.rows()) + " samples, must have less than 2^28");
  if ((series.array().abs() <= largest_sample).all()) return;
  for (Eigen::Index t = 0; t < series.rows(); ++t)
    for (const double value : series.row(t))
      require(std::abs(value) <= largest_sample, name + " has " + std::to_string(value) + " in sample " +
                                                     std::to_string(t) + ", must be finite and within 1e100");
}

void require_sample(const double* sample, int dimensions) {
  for (int d = 0; d < dimensions; ++d)
    if (!(std::abs(sample[d]) <= largest_sample) && !std::isnan(sample[d]))
      throw std::invalid_argument("sample[" + std::to_string(d) + "] is " + std::to_string(sample[d]) +
                                  ", must be NaN (not seen) or within 1e100");
}

}  // namespace lfdcore::detail
