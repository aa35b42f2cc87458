// Hybrid A*: a path for the chair's whole body in (x, y, heading) among obstacle points (Dolgov et al. 2010).
#pragma once

#include <memory>
#include <optional>

#include "lfdcore/geometry.hpp"
#include "lfdcore/grid/obstacle_points.hpp"
#include "lfdcore/path.hpp"

namespace lfdcore {

/// Costs are lengths: what one would rather drive than suffer the thing once, or per unit of it.
struct HybridAstarConfig {
  double margin = 0.04;            ///< kept free around the footprint [m]
  double goal_tolerance = 0.15;    ///< of the base_link origin [m]
  double heading_tolerance = 0.2;  ///< of the final heading, where one is asked for [rad]
  double window = 3.5;             ///< base_link's origin stays within this of the start in x and in y [m]
  int max_expansions = 2500;       ///< of a search; failed searches cost all of them
  bool allow_reverse = false;      ///< drive backwards too
  double turn_cost = 0.1;          ///< [m/rad]
  double curvature_cost = 0.05;    ///< of a change of curvature [m per 1/m]
  double pivot_cost = 1.0;         ///< of starting to turn in place [m]
  double pivot_turn_cost = 0.5;    ///< of turning in place [m/rad]
  double reverse_cost = 2.0;       ///< added to each metre backwards
  double clearance_cost = 2.0;     ///< added to each metre at clearance 0, less by the square up to `comfort`
  double comfort = 0.3;            ///< clearance beyond the footprint from which on more is not better [m]
  double eagerness = 2.0;          ///< weight of the heuristic; 1: least cost, more: sooner found
};

/// Throws std::invalid_argument, naming the field, the bound and the unit.
void validate(const HybridAstarConfig& config);

enum class HybridAstarOutcome {
  found,
  no_path,          ///< the whole window was searched
  expansion_limit,  ///< gave up
  start_blocked,    ///< the footprint itself holds an obstacle point at the start
  goal_blocked      ///< no pose within the goal's tolerance is free
};

/// The outcome's name, such as "no_path".
const char* to_string(HybridAstarOutcome outcome);

struct HybridAstarResult {
  bool found = false;
  PosePath path = PosePath(0, 3);  ///< (N, 3) x, y [m], yaw [rad], neighbours within 0.05 m and 0.1 rad; else (0, 3)
  int expansions = 0;
  double cost = 0;    ///< [m], 0 unless found
  double margin = 0;  ///< kept free around the footprint all along the path [m]
  HybridAstarOutcome outcome = HybridAstarOutcome::no_path;
};

/// A planner for one footprint that keeps its memory (about 3 MB at the default window) from search to search. State:
/// (x, y) in 0.05 m cells, 32 headings; moves: arcs of 0.15 m with curvatures 0, +-0.6, +-1.3, +-2.2 1/m, turns in
/// place by 1/32; heuristic: the larger of the straight distance and the distance around obstacles grown by the
/// inscribed circle. Not to be shared between threads.
class HybridAstar {
 public:
  explicit HybridAstar(const Footprint& footprint, const HybridAstarConfig& config = {});
  ~HybridAstar();
  HybridAstar(HybridAstar&&) noexcept;
  HybridAstar& operator=(HybridAstar&&) noexcept;

  /// From `start` to base_link's origin within the tolerance of `goal` [m] (and of `goal_heading` [rad]), all in the
  /// frame of the obstacles. Where the start is nearer to an obstacle than the margin, the margin becomes half of what
  /// is free there, so that the chair can still turn. Throws std::invalid_argument for values that are not finite or a
  /// goal outside the window.
  HybridAstarResult solve(const ObstaclePoints& obstacles, const Pose2& start, const Eigen::Vector2d& goal,
                          std::optional<double> goal_heading = std::nullopt);

 private:
  class Search;
  std::unique_ptr<Search> search_;
};

/// One search with a planner of its own; see HybridAstar::solve.
HybridAstarResult solve_hybrid_astar(const ObstaclePoints& obstacles, const Footprint& footprint, const Pose2& start,
                                     const Eigen::Vector2d& goal, const HybridAstarConfig& config = {},
                                     std::optional<double> goal_heading = std::nullopt);

}  // namespace lfdcore
