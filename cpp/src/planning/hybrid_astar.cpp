#include "lfdcore/planning/hybrid_astar.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "clearance_map.hpp"
#include "goal_distance.hpp"
#include "lfdcore/error.hpp"
#include "motion_primitives.hpp"

namespace lfdcore {
namespace {

struct Node {
  Pose2 pose;  // continuous: only the comparison of states is by cells
  double cost = 0;
  int state = 0;
  int parent = -1;
  int move = -1;  // the primitive that led here
};

struct Open {
  double total;  // cost + heuristic
  int node;
  bool operator<(const Open& other) const { return total > other.total; }  // std heaps have the largest first
};

void validate(const Footprint& footprint) {
  require_bounded(footprint);
  require_positive("footprint.front", footprint.front, "m");
  require_positive("footprint.rear", footprint.rear, "m");
  require_positive("footprint.half_width", footprint.half_width, "m");
}

double inscribed_radius(const Footprint& f) { return std::min({f.front, f.rear, f.half_width}); }

}  // namespace

class HybridAstar::Search {
 public:
  Search(const Footprint& footprint, const HybridAstarConfig& config);
  HybridAstarResult solve(const ObstaclePoints& obstacles, const Pose2& start, const Eigen::Vector2d& goal,
                          std::optional<double> goal_heading);
  double window() const { return config_.window; }

 private:
  HybridAstarOutcome prepare();
  HybridAstarOutcome run();
  double free_margin() const;
  void expand(int parent);
  bool try_move(const Node& from, Node& to, const MotionPrimitive& primitive) const;
  double move_cost(const Node& from, const MotionPrimitive& primitive) const;
  double clearance_cost(const Pose2& pose, const MotionPrimitive& primitive) const;
  bool passable(const Pose2& from, const MotionPrimitive& primitive, std::size_t interval) const;
  bool hits(const Pose2& pose, const Footprint& footprint) const;
  double clearance_at_least(const Pose2& pose, const Footprint& footprint) const;
  bool at_goal(const Pose2& pose) const;
  int state_of(const Pose2& pose) const;
  bool beaten(const Node& node) const;
  double heuristic(const Pose2& pose) const;
  double nose_off(const Pose2& from_start, double axle_pays) const;
  double final_turn(double yaw) const;
  void push(const Node& node);
  void forget();
  PosePath path_to_last() const;

  Footprint body_, kept_free_;
  HybridAstarConfig config_;
  std::vector<MotionPrimitive> primitives_;
  ClearanceMap map_;
  GoalDistance distance_;
  std::vector<Node> nodes_;
  std::vector<Open> open_;
  std::vector<std::int32_t> best_;  // cheapest node of each state, -1 where none
  int goal_node_ = -1, expansions_ = 0;
  const ObstaclePoints* obstacles_ = nullptr;
  Pose2 start_;
  Eigen::Vector2d goal_{0, 0};
  std::optional<double> goal_heading_;
};

HybridAstar::Search::Search(const Footprint& footprint, const HybridAstarConfig& config)
    : body_(footprint),
      config_(config),
      primitives_(motion_primitives(footprint.grown(config.margin), config.allow_reverse)),
      map_(config.window),
      distance_(map_),
      best_(static_cast<std::size_t>(map_.cells()) * map_.cells() * headings, -1) {
  const std::size_t most = 1 + primitives_.size() * static_cast<std::size_t>(config.max_expansions);
  nodes_.reserve(most);
  open_.reserve(most);
}

HybridAstarResult HybridAstar::Search::solve(const ObstaclePoints& obstacles, const Pose2& start,
                                             const Eigen::Vector2d& goal, std::optional<double> goal_heading) {
  obstacles_ = &obstacles, goal_ = goal, goal_heading_ = goal_heading;
  start_ = {start.x, start.y, wrap_angle(start.yaw)};
  forget();
  HybridAstarResult result;
  result.margin = free_margin();
  kept_free_ = body_.grown(result.margin);
  result.outcome = prepare();
  if (result.outcome == HybridAstarOutcome::found) result.outcome = run();
  result.expansions = expansions_;
  result.found = result.outcome == HybridAstarOutcome::found;
  if (!result.found) return result;
  result.path = path_to_last();
  result.cost = nodes_[goal_node_].cost;
  return result;
}

// `found` means that there is something to search.
HybridAstarOutcome HybridAstar::Search::prepare() {
  if (obstacles_->collides(start_, body_)) return HybridAstarOutcome::start_blocked;
  map_.build(*obstacles_, {start_.x, start_.y});
  const Eigen::Vector2d goal(goal_.x() - start_.x, goal_.y() - start_.y);
  const DiscCost disc{inscribed_radius(body_), kept_free_.front - body_.front, config_.clearance_cost, config_.comfort};
  if (!distance_.build(map_, goal, config_.goal_tolerance, disc)) return HybridAstarOutcome::goal_blocked;
  Node first{start_};
  first.state = state_of(start_);
  push(first);
  return HybridAstarOutcome::found;
}

HybridAstarOutcome HybridAstar::Search::run() {
  while (!open_.empty()) {
    std::pop_heap(open_.begin(), open_.end());
    const int node = open_.back().node;
    open_.pop_back();
    if (best_[nodes_[node].state] != node) continue;
    goal_node_ = node;
    if (at_goal(nodes_[node].pose)) return HybridAstarOutcome::found;
    if (expansions_ == config_.max_expansions) return HybridAstarOutcome::expansion_limit;
    ++expansions_;
    expand(node);
  }
  return HybridAstarOutcome::no_path;
}

double HybridAstar::Search::free_margin() const {
  if (!obstacles_->collides(start_, body_.grown(config_.margin))) return config_.margin;
  double low = 0, high = config_.margin;
  for (int i = 0; i < 10; ++i) {
    const double middle = (low + high) / 2;
    (obstacles_->collides(start_, body_.grown(middle)) ? high : low) = middle;
  }
  return low / 2;
}

void HybridAstar::Search::expand(int parent) {
  const Node from = nodes_[parent];
  for (std::size_t i = 0; i < primitives_.size(); ++i) {
    Node to{from.pose * primitives_[i].end()};
    to.parent = parent;
    to.move = static_cast<int>(i);
    if (try_move(from, to, primitives_[i])) push(to);
  }
}

// The cheap tests first; fills in the state and the cost.
bool HybridAstar::Search::try_move(const Node& from, Node& to, const MotionPrimitive& primitive) const {
  to.state = state_of(to.pose);
  to.cost = from.cost + move_cost(from, primitive);
  if (to.state < 0 || beaten(to) || !std::isfinite(heuristic(to.pose))) return false;
  if (!passable(from.pose, primitive, 1)) return false;
  to.cost += clearance_cost(to.pose, primitive);
  return !beaten(to);
}

double HybridAstar::Search::move_cost(const Node& from, const MotionPrimitive& primitive) const {
  const MotionPrimitive* before = from.move < 0 ? nullptr : &primitives_[from.move];
  if (primitive.pivots()) {
    const bool goes_on = before && before->pivots() && before->turn * primitive.turn > 0;
    return std::abs(primitive.turn) * config_.pivot_turn_cost + (goes_on ? 0.0 : config_.pivot_cost);
  }
  const double bend = std::abs(primitive.curvature - (before ? before->curvature : 0.0));
  const double length = std::abs(primitive.length);
  return length * (primitive.length < 0 ? 1 + config_.reverse_cost : 1) + std::abs(primitive.turn) * config_.turn_cost +
         bend * config_.curvature_cost;
}

// Near obstacles a metre costs more, by the square of what lacks to the comfortable clearance: the middle of a gap.
double HybridAstar::Search::clearance_cost(const Pose2& pose, const MotionPrimitive& primitive) const {
  if (clearance_at_least(pose, body_) >= config_.comfort) return 0;
  const double lack = 1 - std::min(1.0, obstacles_->clearance(pose, body_) / config_.comfort);
  return config_.clearance_cost * lack * lack * std::abs(primitive.length);
}

// Free if no point lies in the rectangle that holds the sweep; else halved, until a hit counts.
bool HybridAstar::Search::passable(const Pose2& from, const MotionPrimitive& primitive, std::size_t interval) const {
  const Interval& part = primitive.intervals[interval];
  const Pose2 middle = from * part.middle;
  const Footprint held{kept_free_.front + part.along, kept_free_.rear + part.along,
                       kept_free_.half_width + part.across};
  if (!hits(middle, held)) return true;
  if (part.last || hits(middle, kept_free_)) return false;
  return passable(from, primitive, 2 * interval) && passable(from, primitive, 2 * interval + 1);
}

bool HybridAstar::Search::hits(const Pose2& pose, const Footprint& footprint) const {
  return clearance_at_least(pose, footprint) <= 0 && obstacles_->collides(pose, footprint);
}

// Three discs side by side along the body cover it.
double HybridAstar::Search::clearance_at_least(const Pose2& pose, const Footprint& footprint) const {
  const double third = (footprint.front + footprint.rear) / 3;
  const double radius = std::hypot(third / 2, footprint.half_width);
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  double least = std::numeric_limits<double>::infinity();
  for (const double x : {third / 2, third * 3 / 2, third * 5 / 2}) {
    const double ahead = x - footprint.rear;
    least = std::min(least, map_.at_least(pose.x + c * ahead, pose.y + s * ahead) - radius);
  }
  return least;
}

bool HybridAstar::Search::at_goal(const Pose2& pose) const {
  if (std::hypot(pose.x - goal_.x(), pose.y - goal_.y()) > config_.goal_tolerance) return false;
  return !goal_heading_ || std::abs(wrap_angle(pose.yaw - *goal_heading_)) <= config_.heading_tolerance;
}

// -1 outside the window.
int HybridAstar::Search::state_of(const Pose2& pose) const {
  const int ix = map_.index(pose.x - start_.x), iy = map_.index(pose.y - start_.y);
  if (!map_.contains(ix, iy)) return -1;
  const auto heading = static_cast<int>(std::lround((pose.yaw - start_.yaw) / heading_step)) & (headings - 1);
  return (iy * map_.cells() + ix) * headings + heading;
}

bool HybridAstar::Search::beaten(const Node& node) const {
  const std::int32_t rival = node.state < 0 ? -1 : best_[node.state];
  return rival >= 0 && nodes_[rival].cost <= node.cost;
}

// What the axle's disc still has to pay at least; infinite where it cannot come to the goal.
double HybridAstar::Search::heuristic(const Pose2& pose) const {
  const Pose2 from_start{pose.x - start_.x, pose.y - start_.y, pose.yaw};
  const double disc = distance_.at(from_start.x, from_start.y);
  const double straight = std::hypot(pose.x - goal_.x(), pose.y - goal_.y()) - config_.goal_tolerance;
  const double driving = std::max(straight, disc + nose_off(from_start, disc));
  return config_.eagerness * std::max(driving, final_turn(pose.yaw));
}

// How much the nose does not lie ahead of the axle on the way: a turn through that angle at the tightest curvature
// costs about as much. Infinite where the nose's disc cannot come to the goal.
double HybridAstar::Search::nose_off(const Pose2& from_start, double axle_pays) const {
  const double ahead = body_.front - inscribed_radius(body_);
  const Eigen::Vector2d nose = from_start * Eigen::Vector2d(ahead, 0);
  if (!std::isfinite(axle_pays) || !distance_.covers(nose.x(), nose.y())) return 0;
  const double nose_pays = distance_.at(nose.x(), nose.y());
  return std::isfinite(nose_pays) ? std::clamp(nose_pays - axle_pays + ahead, 0.0, axle_pays) : nose_pays;
}

// The way to the final heading at the tightest curvature, or in place.
double HybridAstar::Search::final_turn(double yaw) const {
  if (!goal_heading_) return 0;
  const double turn = std::abs(wrap_angle(yaw - *goal_heading_)) - config_.heading_tolerance;
  return std::max(0.0, turn) * std::min(config_.pivot_turn_cost, config_.turn_cost + 1 / tightest_curvature);
}

void HybridAstar::Search::push(const Node& node) {
  const double remaining = heuristic(node.pose);
  if (!std::isfinite(remaining)) return;
  const auto added = static_cast<std::int32_t>(nodes_.size());
  nodes_.push_back(node);
  best_[node.state] = added;
  open_.push_back({node.cost + remaining, added});
  std::push_heap(open_.begin(), open_.end());
}

void HybridAstar::Search::forget() {
  for (const Node& node : nodes_) best_[node.state] = -1;
  nodes_.clear();
  open_.clear();
  expansions_ = 0;
}

PosePath HybridAstar::Search::path_to_last() const {
  std::size_t count = 1;
  for (int i = goal_node_; nodes_[i].parent >= 0; i = nodes_[i].parent)
    count += primitives_[nodes_[i].move].poses.size();
  PosePath path(static_cast<Eigen::Index>(count), 3);
  auto row = static_cast<Eigen::Index>(count);
  for (int i = goal_node_; nodes_[i].parent >= 0; i = nodes_[i].parent) {
    const auto& poses = primitives_[nodes_[i].move].poses;
    for (auto pose = poses.rbegin(); pose != poses.rend(); ++pose) {
      const Pose2 at = nodes_[nodes_[i].parent].pose * *pose;
      path.row(--row) << at.x, at.y, at.yaw;
    }
  }
  path.row(0) << start_.x, start_.y, start_.yaw;
  return path;
}

void validate(const HybridAstarConfig& config) {
  require_between("margin", config.margin, 0, 1, "m");
  require_between("goal_tolerance", config.goal_tolerance, ClearanceMap::resolution, 1, "m");
  require_between("heading_tolerance", config.heading_tolerance, 0, pi, "rad");
  require_between("window", config.window, 0.5, 10, "m");
  require_between("max_expansions", config.max_expansions, 1, 1e6, "");
  for (const auto& [name, cost] : {std::pair{"turn_cost", config.turn_cost},
                                   {"curvature_cost", config.curvature_cost},
                                   {"pivot_cost", config.pivot_cost},
                                   {"pivot_turn_cost", config.pivot_turn_cost},
                                   {"reverse_cost", config.reverse_cost},
                                   {"clearance_cost", config.clearance_cost}})
    require_between(name, cost, 0, 1e3, "");
  require_between("eagerness", config.eagerness, 1, 10, "");
  require_positive("comfort", config.comfort, "m");
}

const char* to_string(HybridAstarOutcome outcome) {
  constexpr const char* names[] = {"found", "no_path", "expansion_limit", "start_blocked", "goal_blocked"};
  return names[static_cast<int>(outcome)];
}

HybridAstar::HybridAstar(const Footprint& footprint, const HybridAstarConfig& config) {
  validate(footprint);
  validate(config);
  search_ = std::make_unique<Search>(footprint, config);
}

HybridAstar::~HybridAstar() = default;
HybridAstar::HybridAstar(HybridAstar&&) noexcept = default;
HybridAstar& HybridAstar::operator=(HybridAstar&&) noexcept = default;

HybridAstarResult HybridAstar::solve(const ObstaclePoints& obstacles, const Pose2& start, const Eigen::Vector2d& goal,
                                     std::optional<double> goal_heading) {
  require_finite("start.x", start.x, "m");
  require_finite("start.y", start.y, "m");
  require_finite("start.yaw", start.yaw, "rad");
  const double window = search_->window();
  require_between("goal x from the start", goal.x() - start.x, -window, window, "m");
  require_between("goal y from the start", goal.y() - start.y, -window, window, "m");
  if (goal_heading) require_finite("goal_heading", *goal_heading, "rad");
  return search_->solve(obstacles, start, goal, goal_heading);
}

HybridAstarResult solve_hybrid_astar(const ObstaclePoints& obstacles, const Footprint& footprint, const Pose2& start,
                                     const Eigen::Vector2d& goal, const HybridAstarConfig& config,
                                     std::optional<double> goal_heading) {
  return HybridAstar(footprint, config).solve(obstacles, start, goal, goal_heading);
}

}  // namespace lfdcore
