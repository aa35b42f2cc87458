// How a motion depends on its parameters: for one degree of freedom 5.1 is linear in (w, g, y0, y'0).
#pragma once

#include <memory>
#include <vector>

#include "basis_table.hpp"

namespace lfdcore::detail {

/// Columns of a response: w (M), g, y0, y'0, zeros up to a multiple of 8.
std::size_t response_width(const DmpConfig& config);

/// Walks along normalised time with the rows of positions and velocities at hand.
class ResponseWalk {
 public:
  ResponseWalk(const DmpConfig& config, double begin = 0);

  /// To normalised time s >= time(). May allocate nothing.
  void advance_to(double time);

  double time() const { return time_; }
  const std::vector<double>& positions() const { return positions_; }
  const std::vector<double>& velocities() const { return velocities_; }
  const BasisTable& table() const { return table_; }

 private:
  void add_forced(const ForcedStep& step);
  void set_free();

  BasisTable table_;
  double begin_, time_;
  std::vector<double> positions_, velocities_, basis_;
};

/// The responses of a whole motion, sample after sample.
struct Response {
  std::size_t steps;     ///< of which the rows are padded to a multiple of 8
  RowMatrix transposed;  ///< (width, 3 padded steps): positions, velocities, accelerations in normalised time
};

/// `steps` samples over [begin, begin + span] of normalised time; kept for the next call with the same arguments.
std::shared_ptr<const Response> response(const DmpConfig& config, int steps, double begin, double span);

}  // namespace lfdcore::detail
