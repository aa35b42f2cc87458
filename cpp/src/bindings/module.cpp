#include "common.hpp"
#include "lfdcore/error.hpp"

PYBIND11_MODULE(_core, m) {
  using namespace lfdcore;
  m.doc() =
      "lfdcore's C++ core; import it through lfdcore.grid, .planning, .control, .estimation, .primitives, .kinematics "
      "and .simulation.";
  py::register_exception<DataError>(m, "DataError", PyExc_RuntimeError);
  py::register_exception<ModelError>(m, "ModelError", PyExc_RuntimeError);
  py::register_exception<DeviceError>(m, "DeviceError", PyExc_RuntimeError);
  auto geometry = m.def_submodule("geometry", "Planar poses, twists, paths and the chair's outline.");
  auto grid = m.def_submodule("grid", "Occupancy grids, scans, distance fields and ray casting.");
  auto simulation = m.def_submodule("simulation", "The simulated chair in its world.");
  auto planning =
      m.def_submodule("planning", "Grid MDPs, dynamic policy programming, Q-learning, user heatmaps, hybrid A*.");
  auto control = m.def_submodule("control", "Pure pursuit, dynamic window, footprint roll-out and the supervisor.");
  auto estimation = m.def_submodule(
      "estimation", "Radial basis function networks, Gaussian processes, differential evolution, intention.");
  auto primitives = m.def_submodule(
      "primitives", "Movement and interaction primitives, dynamic time warping, orientations, sequences of tasks.");
  auto kinematics = m.def_submodule("kinematics", "Robots from URDF: chains, inverse kinematics, joint trajectories.");
  auto hardware = m.def_submodule("hardware", "The joystick's link and its odometry, LIDARs.");
  bind_geometry(geometry);
  bind_grid(grid);
  bind_simulation(simulation);
  bind_dpp(planning);
  bind_hybrid_astar(planning);
  bind_q_learning(planning);
  bind_user_heatmap(planning);
  bind_pure_pursuit(control);
  bind_dynamic_window(control);
  bind_footprint_rollout(control);
  bind_supervisor(control);
  bind_rbf_network(estimation);
  bind_gaussian_process(estimation);
  bind_action_model(estimation);
  bind_dtw(primitives);
  bind_phase_estimator(primitives);
  bind_orientation(primitives);
  bind_sequence(primitives);
  bind_dmp(primitives);
  bind_interaction_primitive(primitives);
  bind_kinematics(kinematics);
  bind_joystick(hardware);
  bind_scip(hardware);
}
