#include "common.hpp"
#include "fields.hpp"
#include "lfdcore/planning/hybrid_astar.hpp"

namespace lfdcore {
namespace {

using Config = HybridAstarConfig;

void bind_config(py::module_& m) {
  bind_settings(m, "HybridAstarConfig",
                "Settings of the hybrid A* search. Costs are lengths [m]: what one would rather drive than suffer "
                "the thing once, or per unit of it.",
                Field("margin", &Config::margin, "kept free around the footprint [m]"),
                Field("goal_tolerance", &Config::goal_tolerance, "of the base_link origin [m]"),
                Field("heading_tolerance", &Config::heading_tolerance, "of the final heading, if asked for [rad]"),
                Field("window", &Config::window, "base_link's origin stays within this of the start in x and y [m]"),
                Field("max_expansions", &Config::max_expansions, "of a search; failed searches cost all of them"),
                Field("allow_reverse", &Config::allow_reverse, "drive backwards too"),
                Field("turn_cost", &Config::turn_cost, "[m/rad]"),
                Field("curvature_cost", &Config::curvature_cost, "of a change of curvature [m per 1/m]"),
                Field("pivot_cost", &Config::pivot_cost, "of starting to turn in place [m]"),
                Field("pivot_turn_cost", &Config::pivot_turn_cost, "of turning in place [m/rad]"),
                Field("reverse_cost", &Config::reverse_cost, "added to each metre backwards"),
                Field("clearance_cost", &Config::clearance_cost, "added to each metre at clearance 0"),
                Field("comfort", &Config::comfort, "clearance from which on more is not better [m]"),
                Field("eagerness", &Config::eagerness, "weight of the heuristic; 1: least cost, more: sooner found"));
}

void bind_result(py::module_& m) {
  py::class_<HybridAstarResult>(m, "HybridAstarResult", "What a hybrid A* search came to.")
      .def_readonly("found", &HybridAstarResult::found)
      .def_readonly("path", &HybridAstarResult::path,
                    "(N, 3) x, y [m], yaw [rad], neighbours within 0.05 m and 0.1 rad; (0, 3) unless found; a view")
      .def_readonly("expansions", &HybridAstarResult::expansions)
      .def_readonly("cost", &HybridAstarResult::cost, "[m], 0 unless found")
      .def_readonly("margin", &HybridAstarResult::margin, "kept free around the footprint all along the path [m]")
      .def_property_readonly(
          "outcome", [](const HybridAstarResult& r) { return to_string(r.outcome); },
          "'found' | 'no_path' (the whole window was searched) | 'expansion_limit' (gave up) | 'start_blocked' (the "
          "footprint holds an obstacle at the start) | 'goal_blocked' (no pose within the goal's tolerance is free)");
}

}  // namespace

void bind_hybrid_astar(py::module_& m) {
  bind_config(m);
  bind_result(m);
  py::class_<HybridAstar>(m, "HybridAstar",
                          "Path for the chair's whole body in (x, y, heading) among obstacle points (Dolgov et al. "
                          "2010). Keeps its memory (about 3 MB) from search to search; not to be shared between "
                          "threads. Cells of 0.05 m, 32 headings, arcs of 0.15 m with curvatures 0, +-0.6, +-1.3, "
                          "+-2.2 1/m, turns in place by 1/32.")
      .def(py::init<const Footprint&, const Config&>(), py::arg("footprint"), py::kw_only(),
           py::arg("config") = Config{})
      .def("solve", &HybridAstar::solve, py::arg("obstacles"), py::arg("start"), py::arg("goal"), py::kw_only(),
           py::arg("goal_heading") = std::nullopt, without_gil(),
           "From `start` to base_link's origin within the tolerance of goal (2,) [m] (and of goal_heading [rad]), all\n"
           "in the frame of the obstacles. Where the start is nearer to an obstacle than the margin, the margin\n"
           "becomes half of what is free there. ValueError for values that are not finite or a goal outside the\n"
           "window.");
  m.def("solve_hybrid_astar", &solve_hybrid_astar, py::arg("obstacles"), py::arg("footprint"), py::arg("start"),
        py::arg("goal"), py::arg("config") = Config{}, py::kw_only(), py::arg("goal_heading") = std::nullopt,
        without_gil(), "One search with a HybridAstar of its own; see HybridAstar.solve.");
}

}  // namespace lfdcore
