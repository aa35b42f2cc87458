#include "lfdcore/simulation/driving_world.hpp"

#include <algorithm>
#include <iterator>
#include <sstream>

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

const ChairConfig& checked(const ChairConfig& chair) {
  validate(chair);
  return chair;
}

const LidarConfig& checked(const LidarConfig& lidar) {
  validate(lidar);
  return lidar;
}

std::vector<double> beam_angles(const LidarConfig& lidar) {
  std::vector<double> angles(lidar.beams);
  for (int beam = 0; beam < lidar.beams; ++beam) angles[beam] = lidar.angle_min() + beam * lidar.angle_increment();
  return angles;
}

std::vector<Eigen::Vector2d> directions(std::span<const double> angles) {
  std::vector<Eigen::Vector2d> made;
  std::transform(angles.begin(), angles.end(), std::back_inserter(made), beam_direction);
  return made;
}

void require_sane(const Pose2& pose) {
  require_between("pose.x", pose.x, -1e6, 1e6, "m");
  require_between("pose.y", pose.y, -1e6, 1e6, "m");
  require_finite("pose.yaw", pose.yaw, "rad");
}

void require_free(const SolidMap& map, const Pose2& pose, const Footprint& footprint) {
  if (!map.touches(pose, footprint)) return;
  std::ostringstream text;
  text << "start pose (" << pose.x << " m, " << pose.y << " m, " << pose.yaw << " rad)";
  if (const auto point = map.contact_point(pose, footprint))
    text << " touches an obstacle at (" << point->x() << ", " << point->y() << ") m, must be free";
  else
    text << " lies outside the map, must be inside";
  throw std::invalid_argument(text.str());
}

}  // namespace

DrivingWorld::DrivingWorld(const OccupancyGrid& grid, const ChairConfig& chair, const LidarConfig& lidar,
                           std::uint64_t seed, bool unknown_is_solid)
    : chair_(checked(chair)),
      lidar_(checked(lidar)),
      seed_(seed),
      map_(grid, unknown_is_solid),
      rays_(map_.grid(), lidar.range_max),
      angles_(beam_angles(lidar)),
      directions_(directions(angles_)) {}

void DrivingWorld::reset(const Pose2& pose) {
  require_sane(pose);
  require_free(map_, pose, chair_.footprint);
  state_ = {};
  state_.pose = {pose.x, pose.y, wrap_angle(pose.yaw)};
  odometry_ = {};
  acting_ = {};
  pending_.clear();
  people_.clear();
  person_contacts_ = {};
  clear_time_ = skid_ = 0;
  steps_ = 0;
  placed_ = true;
}

StepResult DrivingWorld::step(const Twist2& command, double duration) {
  require(placed_, "the world has no start pose yet: call reset(pose) before step");
  require_finite("command.linear", command.linear, "m/s");
  require_finite("command.angular", command.angular, "rad/s");
  require_positive("duration", duration, "s");
  require_between("duration", duration, 0, 10, "s");
  pending_.push_back({state_.stamp + chair_.command_latency, command});
  draw_slip();
  const int before = state_.collisions;
  const int pieces = std::max(1, static_cast<int>(std::ceil(duration / chair_.sub_step - 1e-9)));
  for (int i = 0; i < pieces; ++i) sub_step(duration / pieces);
  ++steps_;
  const Twist2 measured{state_.twist.linear * linear_factor_, state_.twist.angular * angular_factor_};
  return {state_.pose, state_.twist, odometry_, measured, state_.in_contact, state_.collisions > before};
}

/// The wheels turn more (or less) than the chair moves; the share holds for a control period.
void DrivingWorld::draw_slip() {
  const Noise noise(seed_, NoiseStream::slip, steps_);
  linear_factor_ = 1 + chair_.linear_slip + chair_.slip_sd * noise.normal(0);
  angular_factor_ = 1 + chair_.angular_slip + chair_.slip_sd * noise.normal(1);
}

void DrivingWorld::sub_step(double duration) {
  while (!pending_.empty() && pending_.front().stamp <= state_.stamp + 1e-9) {
    acting_ = pending_.front().command;
    pending_.erase(pending_.begin());
  }
  const Twist2 driven = approach(state_.twist, acting_, chair_.limits, duration);
  const double skid = skid_ * std::exp(-duration / chair_.contact.skid_time);
  const BodyMotion motion = move_body(map_, chair_, state_.pose, {driven, skid}, duration);
  state_.pose = motion.pose;
  state_.twist = motion.velocity.twist;
  skid_ = std::abs(motion.velocity.skid) < 1e-4 ? 0 : motion.velocity.skid;
  state_.distance += motion.distance;
  state_.stamp += duration;
  odometry_ =
      integrate(odometry_, {state_.twist.linear * linear_factor_, state_.twist.angular * angular_factor_}, duration);
  note_contact(motion, duration);
  walk_people(duration);
}

void DrivingWorld::walk_people(double duration) {
  for (Person& person : people_) person.position += person.velocity * duration;
  person_contacts_.note(state_.stamp, state_.pose, state_.twist, chair_, people_, duration);
}

/// A contact begins when the body is blocked, and ends when it has been clear by the gap for the time.
void DrivingWorld::note_contact(const BodyMotion& motion, double duration) {
  if (motion.blocked && !state_.in_contact) {
    state_.in_contact = true;
    ++state_.collisions;
    if (const auto point = map_.contact_point(motion.blocked_pose, chair_.footprint)) state_.contact_point = *point;
  }
  if (!state_.in_contact) return;
  const bool clear = !motion.blocked && !map_.touches(motion.pose, chair_.footprint.grown(chair_.contact.release_gap));
  clear_time_ = clear ? clear_time_ + duration : 0;
  state_.in_contact = clear_time_ < chair_.contact.release_time - 1e-9;
}

void DrivingWorld::set_people(std::vector<Person> people) {
  require(placed_, "the world has no start pose yet: call reset(pose) before set_people");
  for (const Person& person : people) validate(person);
  people_ = std::move(people);
}

std::vector<bool> DrivingWorld::people_in_scan() const {
  std::vector<bool> seen(people_.size());
  if (people_.empty()) return seen;
  std::vector<float> ranges(lidar_.beams);
  std::vector<int> met(lidar_.beams, -1);
  cast(ranges, met);
  for (const int person : met)
    if (person >= 0) seen[person] = true;
  return seen;
}

bool DrivingWorld::touches(const Pose2& pose, double margin) const {
  require_sane(pose);
  require_between("margin", margin, 0, 10, "m");
  return map_.touches(pose, chair_.footprint.grown(margin));
}

/// Without noise.
void DrivingWorld::cast(std::span<float> ranges, std::span<int> met) const {
  const Pose2 T_map_laser = state_.pose * lidar_.T_base_laser;
  rays_.cast(T_map_laser, angles_, ranges);
  cast_at_people(T_map_laser, directions_, lidar_.range_max, people_, ranges, met);
}

LaserScan DrivingWorld::scan() const {
  LaserScan made{std::vector<float>(lidar_.beams), lidar_.angle_min(), lidar_.angle_increment(), 0, lidar_.range_max};
  scan(made);
  return made;
}

void DrivingWorld::scan(LaserScan& scan) const {
  require(placed_, "the world has no start pose yet: call reset(pose) before scan");
  require(scan.ranges.size() == static_cast<std::size_t>(lidar_.beams),
          "scan has another number of beams than the LIDAR");
  cast(scan.ranges);
  add_range_noise(lidar_, seed_, steps_, scan.ranges);
}

}  // namespace lfdcore
