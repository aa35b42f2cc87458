#include "common.hpp"
#include "lfdcore/grid/grid.hpp"
#include "lfdcore/grid/laser_scan.hpp"
#include "lfdcore/grid/obstacle_points.hpp"

namespace lfdcore {
namespace {

void bind_occupancy_grid(py::module_& m) {
  py::class_<OccupancyGrid>(m, "OccupancyGrid",
                            "Cells (height, width) of int8: 0 free .. 100 occupied [%], -1 unknown; data[iy, ix]. The "
                            "origin [m] is the corner of cell (0, 0) in the grid's frame (nav_msgs/OccupancyGrid).")
      .def(py::init([](GridOf<std::int8_t> data, double resolution, std::pair<double, double> origin) {
             const GridGeometry where{static_cast<int>(data.cols()), static_cast<int>(data.rows()), resolution,
                                      origin.first, origin.second};
             return OccupancyGrid(where, std::move(data));
           }),
           py::arg("data"), py::arg("resolution"), py::arg("origin") = std::pair{0.0, 0.0})
      .def_property_readonly(
          "data", [](OccupancyGrid& g) -> Eigen::Ref<GridOf<std::int8_t>> { return g.data; },
          py::return_value_policy::reference_internal, "(height, width) int8, a view")
      .def_property_readonly(
          "resolution", [](const OccupancyGrid& g) { return g.geometry.resolution; }, "[m]")
      .def_property_readonly(
          "origin", [](const OccupancyGrid& g) { return std::pair{g.geometry.origin_x, g.geometry.origin_y}; },
          "(x, y) [m] of the corner of cell (0, 0)")
      .def_property_readonly(
          "width", [](const OccupancyGrid& g) { return g.geometry.width; }, "columns")
      .def_property_readonly(
          "height", [](const OccupancyGrid& g) { return g.geometry.height; }, "rows")
      .def("occupied_mask", &OccupancyGrid::occupied_mask, "(height, width) bool: true from 65 % on")
      .def(
          "cell_at",
          [](const OccupancyGrid& g, double x, double y) {
            const Cell c = g.geometry.cell_at(x, y);
            return std::pair{c.ix, c.iy};
          },
          py::arg("x"), py::arg("y"), "(ix, iy) of the cell that holds a point [m]; may lie outside the grid.")
      .def(
          "centre", [](const OccupancyGrid& g, int ix, int iy) { return Eigen::Vector2d(g.geometry.centre({ix, iy})); },
          py::arg("ix"), py::arg("iy"), "(2,) centre of a cell [m]")
      .def(py::pickle(
          [](const OccupancyGrid& g) {
            return py::make_tuple(g.data, g.geometry.resolution, g.geometry.origin_x, g.geometry.origin_y);
          },
          [](const py::tuple& t) {
            auto data = t[0].cast<GridOf<std::int8_t>>();
            const GridGeometry where{static_cast<int>(data.cols()), static_cast<int>(data.rows()), t[1].cast<double>(),
                                     t[2].cast<double>(), t[3].cast<double>()};
            return OccupancyGrid(where, std::move(data));
          }));
}

void bind_laser_scan(py::module_& m) {
  py::class_<LaserScan>(m, "LaserScan",
                        "One sweep of a planar LIDAR (sensor_msgs/LaserScan): ranges (B,) [m], where +inf = nothing "
                        "within range_max, NaN = no measurement (REP-117); angles [rad] in the laser's frame.")
      .def(py::init([](std::vector<float> ranges, double angle_min, double angle_increment, double range_min,
                       double range_max) {
             LaserScan scan{std::move(ranges), angle_min, angle_increment, range_min, range_max};
             validate(scan);
             return scan;
           }),
           py::arg("ranges"), py::arg("angle_min"), py::arg("angle_increment"), py::arg("range_min") = 0.0,
           py::arg("range_max") = 30.0)
      .def_property_readonly(
          "ranges",
          [](py::object self) {
            auto& scan = self.cast<LaserScan&>();
            return py::array_t<float>(static_cast<py::ssize_t>(scan.ranges.size()), scan.ranges.data(), self);
          },
          "(B,) float32 [m], a view")
      .def_readonly("angle_min", &LaserScan::angle_min, "[rad] of beam 0")
      .def_readonly("angle_increment", &LaserScan::angle_increment, "[rad]")
      .def_readonly("range_min", &LaserScan::range_min, "[m]")
      .def_readonly("range_max", &LaserScan::range_max, "[m]")
      .def(
          "angles",
          [](const LaserScan& s) {
            return Eigen::VectorXd(
                s.angle_min + s.angle_increment * Eigen::ArrayXd::LinSpaced(static_cast<Eigen::Index>(s.ranges.size()),
                                                                            0.0, s.ranges.size() - 1.0));
          },
          "(B,) [rad] in the laser's frame")
      .def(py::pickle(
          [](const LaserScan& s) {
            return py::make_tuple(s.ranges, s.angle_min, s.angle_increment, s.range_min, s.range_max);
          },
          [](const py::tuple& t) {
            return LaserScan{t[0].cast<std::vector<float>>(), t[1].cast<double>(), t[2].cast<double>(),
                             t[3].cast<double>(), t[4].cast<double>()};
          }));
}

void bind_obstacle_points(py::module_& m) {
  py::class_<ObstaclePoints>(m, "ObstaclePoints",
                             "Obstacles as points (M, 2) [m] that a LIDAR saw, all in one frame; exact clearance of a "
                             "rectangular body from them.")
      .def(py::init<Path>(), py::arg("points"))
      .def_property_readonly("points", &ObstaclePoints::points, "(M, 2) [m], a view")
      .def("collides", &ObstaclePoints::collides, py::arg("pose"), py::arg("footprint"),
           "True if any point lies inside or on the footprint of a body at `pose`.")
      .def("clearance", &ObstaclePoints::clearance, py::arg("pose"), py::arg("footprint"),
           "Distance [m] from the footprint's edge to the nearest point; 0 if one lies inside, inf without points.");
}

}  // namespace

void bind_grid(py::module_& m) {
  bind_occupancy_grid(m);
  bind_laser_scan(m);
  bind_obstacle_points(m);
}

}  // namespace lfdcore
