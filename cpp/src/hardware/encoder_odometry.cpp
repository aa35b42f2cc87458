#include "lfdcore/hardware/encoder_odometry.hpp"

#include "lfdcore/error.hpp"

namespace lfdcore {
namespace {

// Counts wrap around: their difference is the shorter way.
double difference(std::int32_t from, std::int32_t to) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(to) - static_cast<std::uint32_t>(from));
}

}  // namespace

void validate(const WheelEncoders& config) {
  require_between("left_radius", config.left_radius, 0.01, 1, "m");
  require_between("right_radius", config.right_radius, 0.01, 1, "m");
  require_between("track", config.track, 0.1, 5, "m");
  require_between("edges_per_turn", std::abs(config.edges_per_turn), 4, 1e6, "edges, of either sign");
  require_between("window", config.window, 0.01, 1, "s");
}

EncoderOdometry::EncoderOdometry(const WheelEncoders& config) : config_((validate(config), config)) {}

// The way [m] and the turn [rad] between two counts.
Twist2 EncoderOdometry::moved(const Counts& from, const Counts& to) const {
  const double turn = 2 * pi / config_.edges_per_turn;
  const double left = difference(from.left, to.left) * turn * config_.left_radius;
  const double right = difference(from.right, to.right) * turn * config_.right_radius;
  return {(left + right) / 2, (right - left) / config_.track};
}

void EncoderOdometry::update(double stamp, std::int32_t left, std::int32_t right) {
  require_finite("stamp", stamp, "s");
  const Counts now{stamp, left, right};
  if (counts_.empty()) twist_ = {};
  if (!counts_.empty()) {
    if (stamp <= counts_.back().stamp) return;
    pose_ = integrate(pose_, moved(counts_.back(), now), 1);
    while (counts_.size() > 1 && stamp - counts_[1].stamp >= config_.window) counts_.pop_front();
    const double passed = stamp - counts_.front().stamp;
    const Twist2 way = moved(counts_.front(), now);
    twist_ = {way.linear / passed, way.angular / passed};
  }
  counts_.push_back(now);
}

}  // namespace lfdcore
