// Shared by all bind_*.cpp; the only folder that includes pybind11.
#pragma once

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

namespace py = pybind11;

namespace lfdcore {

void bind_geometry(py::module_& m);
void bind_grid(py::module_& m);
void bind_simulation(py::module_& m);
void bind_dpp(py::module_& m);
void bind_hybrid_astar(py::module_& m);
void bind_q_learning(py::module_& m);
void bind_user_heatmap(py::module_& m);
void bind_pure_pursuit(py::module_& m);
void bind_dynamic_window(py::module_& m);
void bind_footprint_rollout(py::module_& m);
void bind_supervisor(py::module_& m);
void bind_rbf_network(py::module_& m);
void bind_gaussian_process(py::module_& m);
void bind_action_model(py::module_& m);
void bind_dtw(py::module_& m);
void bind_phase_estimator(py::module_& m);
void bind_orientation(py::module_& m);
void bind_sequence(py::module_& m);
void bind_dmp(py::module_& m);
void bind_interaction_primitive(py::module_& m);
void bind_kinematics(py::module_& m);
void bind_joystick(py::module_& m);
void bind_scip(py::module_& m);

using without_gil = py::call_guard<py::gil_scoped_release>;

}  // namespace lfdcore
