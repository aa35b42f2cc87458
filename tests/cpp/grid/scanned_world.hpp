// Walls and round posts that a noisy scanner sees, exactly: for laws of what is made of its scans.
#pragma once

#include <limits>
#include <random>
#include <vector>

#include "lfdcore/grid/laser_scan.hpp"

namespace lfdcore::test {

struct Wall {
  double ax, ay, bx, by;
};
struct Post {
  double x, y, radius;
};

struct ScannedWorld {
  std::vector<Wall> walls;
  std::vector<Post> posts;
  double noise = 0.01;  // sd of a range [m]
  double dropped = 0;   // share of beams that are NaN
  int beams = 181;      // over half a turn
  std::mt19937 rng{1};

  void add_box(double left, double bottom, double right, double top) {
    walls.insert(walls.end(), {{left, bottom, right, bottom},
                               {right, bottom, right, top},
                               {right, top, left, top},
                               {left, top, left, bottom}});
  }

  double cast(double x, double y, double angle) const {
    const double dx = std::cos(angle), dy = std::sin(angle);
    double nearest = std::numeric_limits<double>::infinity();
    for (const Wall& w : walls) {
      const double ex = w.bx - w.ax, ey = w.by - w.ay, det = dx * ey - dy * ex;
      const double t = ((w.ax - x) * ey - (w.ay - y) * ex) / det, u = ((w.ax - x) * dy - (w.ay - y) * dx) / det;
      if (det != 0 && t > 0 && u >= 0 && u <= 1) nearest = std::min(nearest, t);
    }
    for (const Post& p : posts) {
      const double along = (p.x - x) * dx + (p.y - y) * dy, beside = (p.x - x) * dy - (p.y - y) * dx;
      if (along > 0 && std::abs(beside) <= p.radius)
        nearest = std::min(nearest, along - std::sqrt(p.radius * p.radius - beside * beside));
    }
    return nearest;
  }

  LaserScan scan(const Pose2& T_world_laser) {
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform;
    LaserScan scan;
    scan.angle_increment = pi / (beams - 1);
    for (int i = 0; i < beams; ++i) {
      const double range =
          cast(T_world_laser.x, T_world_laser.y, T_world_laser.yaw + scan.angle(i)) + noise * normal(rng);
      scan.ranges.push_back(uniform(rng) < dropped ? std::numeric_limits<float>::quiet_NaN()
                                                   : static_cast<float>(range));
    }
    return scan;
  }
};

}  // namespace lfdcore::test
