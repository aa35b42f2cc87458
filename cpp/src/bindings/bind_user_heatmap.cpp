#include "common.hpp"
#include "lfdcore/path.hpp"
#include "lfdcore/planning/user_heatmap.hpp"

namespace lfdcore {
namespace {

void bind_movement_template(py::module_& m) {
  m.def("arc_orientation", &arc_orientation, py::arg("point"), py::arg("limits") = MotionLimits{},
        "The stick's orientation h = arctan2(left, forward) [rad] in (-pi, pi] whose constant twist leads base_link's "
        "origin through a point (2,) [m]: ahead for x >= 0, else backwards, turned by at most 180 degrees (ERRATA 28). "
        "ValueError for a point that is not finite or is the origin.");
  py::class_<MovementTemplate>(
      m, "MovementTemplate",
      "Movement template and distance filter of Sec. 4.4.1 over the local window, from a dense fan of arcs: those "
      "ahead cover the front half, those backwards the rear half (ERRATA 28). Built once for a chair's limits, in some "
      "100 ms.")
      .def(py::init<const MotionLimits&>(), py::arg("limits") = MotionLimits{}, without_gil())
      .def_property_readonly("limits", &MovementTemplate::limits)
      .def_property_readonly(
          "orientation", [](const MovementTemplate& t) -> const FloatGrid& { return t.orientation(); },
          py::return_value_policy::reference_internal,
          "h_t (100, 100) float32 [rad], a view: circular mean of the stick's orientation over the arcs through a cell")
      .def_property_readonly(
          "distance_filter", [](const MovementTemplate& t) -> const FloatGrid& { return t.distance_filter(); },
          py::return_value_policy::reference_internal,
          "(100, 100) float32 in (0, 1], a view: mean length of the arcs up to a cell, divided by the largest")
      .def(py::pickle([](const MovementTemplate& t) { return py::make_tuple(t.limits()); },
                      [](const py::tuple& t) { return MovementTemplate(t[0].cast<MotionLimits>()); }));
}

void bind_moments(py::module_& m) {
  py::class_<OrientationMoments>(m, "OrientationMoments",
                                 "Mean [rad] and variance [rad^2] of a stick's orientation h = arctan2(left, forward): "
                                 "0 = forward, positive to the left.")
      .def(py::init([](double mean, double variance) { return OrientationMoments{mean, variance}; }), py::arg("mean"),
           py::arg("variance"))
      .def_readonly("mean", &OrientationMoments::mean, "[rad]")
      .def_readonly("variance", &OrientationMoments::variance, "[rad^2]")
      .def(py::pickle([](const OrientationMoments& o) { return py::make_tuple(o.mean, o.variance); },
                      [](const py::tuple& t) { return OrientationMoments{t[0].cast<double>(), t[1].cast<double>()}; }));
  m.def(
      "joystick_orientation",
      [](const Eigen::Vector2d& mean, const Eigen::Vector2d& variance) {
        return joystick_orientation({mean.x(), mean.y(), variance.x(), variance.y()});
      },
      py::arg("mean"), py::arg("variance"),
      "Moments of h from means (2,) [forward, left] and variances (2,) of the stick's axes, Eq. 4.1-4.2 as corrected "
      "(ERRATA 25). The sd is kept within [0.05, pi / sqrt(3)] rad: first order is useless beyond (ERRATA 26). None "
      "for a stick at rest, closer than 1e-6 to its centre. ValueError for values that are not finite or a negative "
      "variance.");
}

void bind_heatmap(py::module_& m) {
  py::class_<UserHeatmap>(m, "UserHeatmap", "A user heatmap over the local window, before and after the filter.")
      .def_property_readonly(
          "density", [](const UserHeatmap& u) -> const FloatGrid& { return u.density; },
          py::return_value_policy::reference_internal, "(100, 100) float32 [1/rad], a view: the weights of Eq. 4.3")
      .def_property_readonly(
          "heatmap", [](const UserHeatmap& u) -> const FloatGrid& { return u.heatmap; },
          py::return_value_policy::reference_internal,
          "(100, 100) float32, a view: density times distance filter, divided by the maximum (F12)");
  m.def(
      "user_heatmap",
      [](const MovementTemplate& movement, const OrientationMoments& orientation) {
        auto result = std::make_unique<UserHeatmap>();
        user_heatmap(movement, orientation, *result);
        return result;
      },
      py::arg("template"), py::arg("orientation"), without_gil(),
      "The heatmap of Sec. 4.4.2: Eq. 4.3 with wrapped differences (ERRATA 27), times the distance filter. ValueError "
      "for a mean that is not finite or a variance that is not within 1e-6..1e6 rad^2.");
  m.def("compliance", &compliance, py::arg("control_point"), py::arg("orientation"), py::arg("limits") = MotionLimits{},
        "How well a control point (2,) [m, base_link] complies with a stick's OrientationMoments, in [0, 1]: the "
        "density at the point's exact orientation relative to its peak, unfiltered (ERRATA 29); above .9 within .46 "
        "sd. 1 at the origin. ValueError as user_heatmap, and for a point that is not finite.");
  m.def(
      "compliances",
      [](const Eigen::Ref<const Path>& points, const OrientationMoments& orientation, const MotionLimits& limits) {
        Eigen::VectorXd result(points.rows());
        for (Eigen::Index i = 0; i < points.rows(); ++i)
          result[i] = compliance(points.row(i).transpose(), orientation, limits);
        return result;
      },
      py::arg("control_points"), py::arg("orientation"), py::arg("limits") = MotionLimits{}, without_gil(),
      "`compliance` of each of N points (N, 2) [m, base_link] -> (N,).");
}

}  // namespace

void bind_user_heatmap(py::module_& m) {
  bind_movement_template(m);
  bind_moments(m);
  bind_heatmap(m);
}

}  // namespace lfdcore
