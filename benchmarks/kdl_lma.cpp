// KDL's Levenberg-Marquardt solver for bench_inverse_kinematics.py. Standard input: n; per joint 12 numbers (the upper
// rows of its fixed transform), lower, upper; 12 of the tool; m; per pose 12 numbers. Output per pose: the microseconds
// of one call from mid-range, then the n joints.
#include <chrono>
#include <cstdio>
#include <iostream>
#include <kdl/chain.hpp>
#include <kdl/chainiksolverpos_lma.hpp>

namespace {

KDL::Frame read_frame() {
  double v[12];
  for (double& x : v) std::cin >> x;
  return {KDL::Rotation(v[0], v[1], v[2], v[4], v[5], v[6], v[8], v[9], v[10]), KDL::Vector(v[3], v[7], v[11])};
}

}  // namespace

int main() {
  unsigned n = 0, m = 0;
  std::cin >> n;
  KDL::Chain chain;
  KDL::JntArray middle(n), found(n);
  for (unsigned i = 0; i < n; ++i) {
    const KDL::Frame F = read_frame();
    double lower, upper;
    std::cin >> lower >> upper;
    middle(i) = 0.5 * (lower + upper);
    chain.addSegment(KDL::Segment(KDL::Joint("j", F.p, F.M * KDL::Vector(0, 0, 1), KDL::Joint::RotAxis), F));
  }
  chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::Fixed), read_frame()));
  // The rotation counts 0.01 in its error by default: 1e-6 there is 1e-4 rad.
  KDL::ChainIkSolverPos_LMA solver(chain, 1e-6, 500);
  std::cin >> m;
  for (unsigned k = 0; k < m; ++k) {
    const KDL::Frame wanted = read_frame();
    const auto start = std::chrono::steady_clock::now();
    solver.CartToJnt(middle, wanted, found);
    std::printf("%.3f", std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count());
    for (unsigned i = 0; i < n; ++i) std::printf(" %.15g", found(i));
    std::printf("\n");
  }
}
