#include <sstream>

#include "common.hpp"
#include "fields.hpp"
#include "lfdcore/geometry.hpp"
#include "lfdcore/motion.hpp"
#include "lfdcore/path.hpp"

namespace lfdcore {
namespace {

template <class... Values>
std::string describe(const char* name, Values... values) {
  std::ostringstream text;
  text << name << '(';
  const char* comma = "";
  ((text << comma << values, comma = ", "), ...);
  text << ')';
  return text.str();
}

void bind_pose(py::module_& m) {
  py::class_<Pose2>(m, "Pose2",
                    "Position x, y [m] and heading yaw [rad]; T_a_b maps coordinates of frame b into frame a.")
      .def(py::init([](double x, double y, double yaw) { return Pose2{x, y, yaw}; }), py::arg("x") = 0.0,
           py::arg("y") = 0.0, py::arg("yaw") = 0.0)
      .def_readwrite("x", &Pose2::x, "[m]")
      .def_readwrite("y", &Pose2::y, "[m]")
      .def_readwrite("yaw", &Pose2::yaw, "[rad]")
      .def(
          "__mul__", [](const Pose2& a, const Pose2& b) { return a * b; }, py::is_operator(), "T_a_c = T_a_b * T_b_c")
      .def("inverse", &Pose2::inverse, "T_b_a")
      .def(
          "transform", [](const Pose2& T, const Path& points) { return transform(T, points); }, py::arg("points"),
          "Points (N, 2) [m] of frame b in frame a.")
      .def("__eq__", [](const Pose2& a, const Pose2& b) { return a.x == b.x && a.y == b.y && a.yaw == b.yaw; })
      .def(
          "__iter__", [](const Pose2& p) { return py::iter(py::make_tuple(p.x, p.y, p.yaw)); },
          "x, y, yaw in turn, so that tuple(pose) and numpy.array([*pose]) work.")
      .def("__repr__", [](const Pose2& p) { return describe("Pose2", p.x, p.y, p.yaw); })
      .def(py::pickle(
          [](const Pose2& p) { return py::make_tuple(p.x, p.y, p.yaw); },
          [](const py::tuple& t) { return Pose2{t[0].cast<double>(), t[1].cast<double>(), t[2].cast<double>()}; }));
}

void bind_twist(py::module_& m) {
  py::class_<Twist2>(m, "Twist2",
                     "Velocity of a differential drive: linear [m/s] ahead, angular [rad/s] anticlockwise.")
      .def(py::init([](double linear, double angular) { return Twist2{linear, angular}; }), py::arg("linear") = 0.0,
           py::arg("angular") = 0.0)
      .def_readwrite("linear", &Twist2::linear, "[m/s]")
      .def_readwrite("angular", &Twist2::angular, "[rad/s]")
      .def("__eq__", [](const Twist2& a, const Twist2& b) { return a.linear == b.linear && a.angular == b.angular; })
      .def("__iter__", [](const Twist2& t) { return py::iter(py::make_tuple(t.linear, t.angular)); })
      .def("__repr__", [](const Twist2& t) { return describe("Twist2", t.linear, t.angular); })
      .def(py::pickle([](const Twist2& t) { return py::make_tuple(t.linear, t.angular); },
                      [](const py::tuple& t) { return Twist2{t[0].cast<double>(), t[1].cast<double>()}; }));
}

void bind_footprint(py::module_& m) {
  py::class_<Footprint>(m, "Footprint",
                        "A rectangle around the axle's centre: front, rear and half_width [m]. Default: the CAS chair "
                        "(Sec. 3.2), 0.8 m from axle to front edge, 0.7 m wide.")
      .def(py::init([](double front, double rear, double half_width) { return Footprint{front, rear, half_width}; }),
           py::arg("front") = Footprint{}.front, py::arg("rear") = Footprint{}.rear,
           py::arg("half_width") = Footprint{}.half_width)
      .def_readwrite("front", &Footprint::front, "[m]")
      .def_readwrite("rear", &Footprint::rear, "[m]")
      .def_readwrite("half_width", &Footprint::half_width, "[m]")
      .def("grown", &Footprint::grown, py::arg("margin"), "The rectangle grown by a margin [m] on every side.")
      .def("outer_radius", &Footprint::outer_radius, "Radius [m] of the circle around the axle that holds it.")
      .def(
          "corners",
          [](const Footprint& f) {
            Path points(4, 2);
            const auto corners = f.corners();
            for (int i = 0; i < 4; ++i) points.row(i) = corners[i].transpose();
            return points;
          },
          "(4, 2) [m] in base_link, anticlockwise from the front left.")
      .def("__eq__",
           [](const Footprint& a, const Footprint& b) {
             return a.front == b.front && a.rear == b.rear && a.half_width == b.half_width;
           })
      .def("__repr__", [](const Footprint& f) { return describe("Footprint", f.front, f.rear, f.half_width); })
      .def(py::pickle(
          [](const Footprint& f) { return py::make_tuple(f.front, f.rear, f.half_width); },
          [](const py::tuple& t) { return Footprint{t[0].cast<double>(), t[1].cast<double>(), t[2].cast<double>()}; }));
}

void bind_motion(py::module_& m) {
  bind_settings(m, "MotionLimits", "Speeds [m/s, rad/s] and accelerations [m/s^2, rad/s^2] of the chair, all positive.",
                Field("max_linear", &MotionLimits::max_linear, "ahead [m/s]"),
                Field("max_reverse", &MotionLimits::max_reverse, "backwards [m/s], positive"),
                Field("max_angular", &MotionLimits::max_angular, "[rad/s]"),
                Field("linear_acceleration", &MotionLimits::linear_acceleration, "speeding up [m/s^2]"),
                Field("linear_braking", &MotionLimits::linear_braking, "slowing down [m/s^2]"),
                Field("angular_acceleration", &MotionLimits::angular_acceleration, "either way [rad/s^2]"));
  m.def("approach", &approach, py::arg("current"), py::arg("wanted"), py::arg("limits"), py::arg("duration"),
        "The twist after `duration` [s] of changing `current` towards `wanted` as fast as the limits allow; `wanted` "
        "beyond the speed limits is cut to them.");
}

}  // namespace

void bind_geometry(py::module_& m) {
  bind_pose(m);
  bind_twist(m);
  bind_footprint(m);
  bind_motion(m);
  m.def("wrap_angle", py::vectorize(&wrap_angle), py::arg("angle"), "The same angle(s) [rad] in (-pi, pi].");
  m.def("integrate", &integrate, py::arg("pose"), py::arg("twist"), py::arg("duration"),
        "The pose after following a constant twist for a duration [s], exactly (a circular arc).");
  m.def("arc_length", &arc_length, py::arg("path"),
        "Distance [m] travelled up to each point of a path (N, 2) -> (N,).");
  m.def("resample", &resample, py::arg("path"), py::arg("count"),
        "The path (N, 2) [m] at `count` (2 to 1 000 000) points equally spaced by arc length -> (count, 2). ValueError "
        "for other counts, a path without points, and points or a length that are not finite.");
}

}  // namespace lfdcore
