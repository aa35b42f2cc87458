#include "response.hpp"

#include <deque>
#include <mutex>

#include "small_products.hpp"

namespace lfdcore::detail {

std::size_t response_width(const DmpConfig& config) {
  return padded(static_cast<std::size_t>(config.basis_functions) + 3);
}

ResponseWalk::ResponseWalk(const DmpConfig& config, double begin)
    : table_(config),
      begin_(begin),
      time_(begin),
      positions_(response_width(config)),
      velocities_(response_width(config)),
      basis_(table_.width()) {
  set_free();
}

void ResponseWalk::advance_to(double time) {
  const int steps = steps_within(table_.config(), time - time_);
  const ForcedStep step(table_.config(), (time - time_) / steps);
  for (int i = 0; i < steps && time > time_; ++i) {
    add_forced(step);
    time_ = i + 1 == steps ? time : time_ + step.duration;
  }
  set_free();
}

void ResponseWalk::add_forced(const ForcedStep& step) {
  const std::size_t count = table_.functions();
  for (std::size_t i = 0; i < count; ++i) {
    const double y = positions_[i], v = velocities_[i];
    positions_[i] = step.free.yy * y + step.free.yv * v;
    velocities_[i] = step.free.vy * y + step.free.vv * v;
  }
  for (int node = 0; node < ForcedStep::nodes; ++node) {
    table_.row_at(time_ + step.at[node], basis_.data());
    for (std::size_t i = 0; i < count; ++i) positions_[i] += step.position[node] * basis_[i];
    for (std::size_t i = 0; i < count; ++i) velocities_[i] += step.velocity[node] * basis_[i];
  }
}

// y - g and y' follow the transition: the columns of g, y0, y'0.
void ResponseWalk::set_free() {
  const Transition free = transition(table_.config(), time_ - begin_);
  double* y = positions_.data() + table_.functions();
  double* v = velocities_.data() + table_.functions();
  y[0] = 1 - free.yy, y[1] = free.yy, y[2] = free.yv;
  v[0] = -free.vy, v[1] = free.vy, v[2] = free.vv;
}

namespace {

struct Key {
  DmpConfig config;
  int steps;
  double begin, span;
  bool operator==(const Key&) const = default;
};

Response make_response(const Key& key) {
  const std::size_t width = response_width(key.config), steps = static_cast<std::size_t>(key.steps);
  const Eigen::Index padded_steps = static_cast<Eigen::Index>(padded(steps));
  Response made{steps, RowMatrix::Zero(static_cast<Eigen::Index>(width), 3 * padded_steps)};
  ResponseWalk walk(key.config, key.begin);
  Eigen::VectorXd basis(static_cast<Eigen::Index>(walk.table().width()));
  const double k = key.config.stiffness * key.config.damping;
  for (int i = 0; i < key.steps; ++i) {
    walk.advance_to(key.begin + key.span * i / (key.steps - 1));
    const Eigen::Map<const Eigen::VectorXd> y(walk.positions().data(), made.transposed.rows());
    const Eigen::Map<const Eigen::VectorXd> v(walk.velocities().data(), made.transposed.rows());
    made.transposed.col(i) = y;
    made.transposed.col(padded_steps + i) = v;
    auto acceleration = made.transposed.col(2 * padded_steps + i);  // 5.1
    acceleration = -k * y - key.config.stiffness * v;
    walk.table().row_at(walk.time(), basis.data());
    acceleration.head(key.config.basis_functions) += basis.head(key.config.basis_functions);
    acceleration[key.config.basis_functions] += k;
  }
  return made;
}

// The last few responses: robots and studies ask for the same grid again and again.
class ResponseCache {
 public:
  std::shared_ptr<const Response> get(const Key& key) {
    {
      const std::lock_guard lock(busy_);
      for (const auto& [known, response] : kept_)
        if (known == key) return response;
    }
    auto made = std::make_shared<const Response>(make_response(key));
    const std::lock_guard lock(busy_);
    kept_.emplace_front(key, made);
    if (kept_.size() > most) kept_.pop_back();
    return made;
  }

 private:
  static constexpr std::size_t most = 8;
  std::mutex busy_;
  std::deque<std::pair<Key, std::shared_ptr<const Response>>> kept_;
};

}  // namespace

std::shared_ptr<const Response> response(const DmpConfig& config, int steps, double begin, double span) {
  static ResponseCache cache;
  return cache.get({config, steps, begin, span});
}

}  // namespace lfdcore::detail
