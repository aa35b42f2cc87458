#include "arrays.hpp"
#include "common.hpp"
#include "fields.hpp"
#include "lfdcore/error.hpp"
#include "lfdcore/grid/distance_field.hpp"
#include "lfdcore/grid/grid.hpp"
#include "lfdcore/grid/heatmap_map.hpp"
#include "lfdcore/grid/laser_scan.hpp"
#include "lfdcore/grid/obstacle_points.hpp"
#include "lfdcore/grid/ray_casting.hpp"
#include "lfdcore/grid/rolling_map.hpp"
#include "lfdcore/grid/scan_mapping.hpp"

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
                        "within range_max, -inf = closer than range_min, NaN = no measurement (REP-117; read_beams); "
                        "angles [rad] in the laser's frame. A broken scanner may give a scan without beams.")
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
      .def(pickled_by_name(Field("ranges", &LaserScan::ranges), Field("angle_min", &LaserScan::angle_min),
                           Field("angle_increment", &LaserScan::angle_increment),
                           Field("range_min", &LaserScan::range_min), Field("range_max", &LaserScan::range_max)));
}

void bind_obstacle_points(py::module_& m) {
  py::class_<ObstaclePoints>(
      m, "ObstaclePoints",
      "Obstacles as points (M, 2) [m] that a LIDAR saw, all in one frame; exact clearance of a "
      "rectangular body from them.\n\n"
      "uncertainty (M,) [m], 0 to 100: how much nearer than its point each obstacle may be, e.g. "
      "some standard errors of a fused range; empty: 0 for all. The supervisor keeps that much "
      "more distance; collides() and clearance() are about the points alone.\n"
      "ValueError for points that are not finite, and for uncertainties out of their bounds or "
      "not as many as the points.")
      .def(py::init([](Path points, const Eigen::VectorXd& uncertainty) {
             return ObstaclePoints(std::move(points), {uncertainty.begin(), uncertainty.end()});
           }),
           py::arg("points"), py::arg("uncertainty") = Eigen::VectorXd())
      .def_property_readonly("points", &ObstaclePoints::points, "(M, 2) [m], a view")
      .def_property_readonly(
          "uncertainty",
          [](const ObstaclePoints& o) {
            return Eigen::Map<const Eigen::VectorXd>(o.uncertainty().data(), o.points().rows());
          },
          "(M,) [m], a view")
      .def("collides", &ObstaclePoints::collides, py::arg("pose"), py::arg("footprint"),
           "True if any point lies inside or on the footprint of a body at `pose`. ValueError if either is not finite.")
      .def("clearance", &ObstaclePoints::clearance, py::arg("pose"), py::arg("footprint"),
           "Distance [m] from the footprint's edge to the nearest point; 0 if one lies inside, inf without points. "
           "ValueError if pose or footprint is not finite.")
      .def(
          "__len__", [](const ObstaclePoints& o) { return o.points().rows(); }, "number of points")
      .def(py::pickle(
          [](const ObstaclePoints& o) { return py::make_tuple(o.points(), o.uncertainty()); },
          [](const py::tuple& t) { return ObstaclePoints(t[0].cast<Path>(), t[1].cast<std::vector<double>>()); }));
}

using Ranges = Contiguous<float>;

std::pair<py::array_t<double>, py::array_t<bool>> beams_of(const Ranges& ranges, double range_min, double range_max) {
  require(ranges.ndim() > 0, "ranges has 0 dimensions, must have at least 1: (..., B)");
  const std::vector<py::ssize_t> shape(ranges.shape(), ranges.shape() + ranges.ndim());
  py::array_t<double> lengths(shape);
  py::array_t<bool> hit(shape);
  const auto count = static_cast<std::size_t>(ranges.size());
  const std::span<const float> from(ranges.data(), count);
  const std::span<double> to(lengths.mutable_data(), count);
  const std::span<bool> ended(hit.mutable_data(), count);
  {
    py::gil_scoped_release release;
    read_beams(from, range_min, range_max, to, ended);
  }
  return {lengths, hit};
}

void bind_read_beams(py::module_& m) {
  m.def(
      "read_beams",
      [](const ArrayLike& ranges, double range_min, double range_max) {
        return beams_of(real_numbers<float>("ranges", ranges), range_min, range_max);
      },
      py::arg("ranges"), py::arg("range_min"), py::arg("range_max"),
      "What ranges mean (REP-117) -> lengths float64 [m], hit bool, both of the shape of `ranges`.\n\n"
      "ranges (..., B) float32 [m]: of one scan or of many; range_min, range_max [m] of the scanner. The space\n"
      "along a beam is free up to its length; if it hit, something is there:\n\n"
      "- finite, in [range_min, range_max): a hit there (with a range_min of 0, 0 is a hit at the laser);\n"
      "- +inf, or at least range_max: free up to range_max, no hit;\n"
      "- -inf: closer than the scanner can tell, taken to be a hit at range_min;\n"
      "- NaN, or finite and below range_min: nothing was measured: length 0, no hit.\n\n"
      "ValueError unless 0 <= range_min <= 1000 m and range_min < range_max, finite; for ranges without a dimension.\n"
      "TypeError for ranges that are no real numbers: text, complex numbers, objects.");
  m.def(
      "read_beams",
      [](const LaserScan& scan) {
        const py::ssize_t beams = static_cast<py::ssize_t>(scan.ranges.size());
        return beams_of(Ranges(beams, scan.ranges.data()), scan.range_min, scan.range_max);
      },
      py::arg("scan"), "The same of one scan -> lengths (B,) float64 [m], hit (B,) bool.");
}

void bind_scan_mapping(py::module_& m) {
  m.def(
      "local_grid", &local_grid, py::arg("scan"), py::arg("T_base_laser"), without_gil(),
      "What one scan shows of the window around base_link -> OccupancyGrid of 100 x 100 cells of 0.05 m (Sec. 3.3).\n\n"
      "Cells along a beam are free (0), the cell at its end is occupied (100, which wins), all others unknown (-1);\n"
      "only the edges of obstacles are seen. What a range means: see read_beams.\n"
      "ValueError for an invalid scan or a pose that is not finite.");
}

void bind_rolling_map(py::module_& m) {
  const RollingMapConfig defaults;
  py::class_<RollingMap>(
      m, "RollingMap",
      "A map of recent scans around the robot, aligned with the odometry frame, for what the LIDAR no longer sees.\n\n"
      "Hits that agree become one point, their mean. A point is remembered for `duration` [s]; it is forgotten "
      "earlier\n"
      "when beams go on behind it, and 3 s after its last hit where a person stepped into space that had just been "
      "seen\n"
      "empty and did not stay there for 3 s.\n\n"
      "radius [m], 0.5 to 20: how far from the robot obstacles() looks. range_noise [m], 0.001 to 0.2: standard "
      "deviation\n"
      "of a range. odometry_error, 0 to 0.5: share of way and turn by which the odometry may be wrong. own_body: the\n"
      "robot's outline; hits deeper inside it than 0.03 m are its own, and what it stood on counts as seen.\n"
      "ValueError for values out of these bounds.")
      .def(py::init([](double duration, double radius, double range_noise, double odometry_error,
                       std::optional<Footprint> own_body) {
             return RollingMap({duration, radius, range_noise, odometry_error, own_body});
           }),
           py::arg("duration") = defaults.duration, py::arg("radius") = defaults.radius,
           py::arg("range_noise") = defaults.range_noise, py::arg("odometry_error") = defaults.odometry_error,
           py::arg("own_body") = py::none())
      .def("insert", &RollingMap::insert, py::arg("stamp"), py::arg("scan"), py::arg("T_base_laser"),
           py::arg("T_odom_base"), without_gil(),
           "Adds a scan taken at `stamp` [s] from T_odom_base; one without beams is as one whose beams all measured "
           "nothing. ValueError, and no change, for an invalid scan or pose or a stamp before the last one.")
      .def("obstacles", &RollingMap::obstacles, py::arg("T_odom_base"), without_gil(),
           "The remembered points within `radius` of base_link, in base_link, each with 3 standard errors as its\n"
           "uncertainty -> ObstaclePoints. With an odometry_error, what the last scan did not hit is given with the "
           "ends\n"
           "of where it may lie by now: the share of the way driven since, and of the turns, moves it.")
      .def("walkers", &RollingMap::walkers, py::arg("T_odom_base"), without_gil(),
           "The points of what walks, as the newest scan hit them -> ObstaclePoints in base_link. obstacles() "
           "holds them too.")
      .def(
          "unseen", &RollingMap::unseen, py::arg("T_odom_base"), py::arg("body"), py::arg("reach"), without_gil(),
          "The edge of the space that nothing is known of -> ObstaclePoints in base_link: centres of 0.05 m cells that "
          "no\nbeam has passed or ended in within `duration`, beside known ones, no farther from the outline of `body` "
          "than\n`reach` [m], 0 to 20. What lies under the body is known, and what was under own_body in any scan. "
          "Gaps "
          "of\nless than 0.25 m count as seen. ValueError for a pose or body that is not finite, or a reach out of "
          "bounds.")
      .def(
          "local_grid", &RollingMap::local_grid, py::arg("T_odom_base"), without_gil(),
          "The window around base_link -> OccupancyGrid (100 x 100 of 0.05 m): occupied where a remembered point lies, "
          "else free where seen free within `duration`, else -1.")
      .def("clear", &RollingMap::clear, "Forgets everything, stamps included.")
      .def_property_readonly_static(
          "own_depth", [](const py::object&) { return RollingMap::own_depth; },
          "[m] inside own_body: what is hit deeper is the robot's own")
      .def_property_readonly(
          "duration", [](const RollingMap& map) { return map.config().duration; }, "[s]")
      .def_property_readonly(
          "radius", [](const RollingMap& map) { return map.config().radius; }, "[m]")
      .def_property_readonly(
          "range_noise", [](const RollingMap& map) { return map.config().range_noise; }, "[m]")
      .def_property_readonly(
          "odometry_error", [](const RollingMap& map) { return map.config().odometry_error; }, "share")
      .def_property_readonly(
          "own_body", [](const RollingMap& map) { return map.config().own_body; }, "Footprint or None")
      .def("__len__", &RollingMap::size, "number of points remembered");
}

void bind_distance_field(py::module_& m) {
  m.def("distance_field", &distance_field, py::arg("occupied"), py::arg("resolution"), without_gil(),
        "Distance from each cell's centre to the nearest occupied centre: (H, W) bool -> (H, W) float32 [m], inf if no "
        "cell is occupied. Exact (Felzenszwalb & Huttenlocher 2012). ValueError for an empty mask or a resolution [m] "
        "that is not positive.");
  m.def("inflate", &inflate, py::arg("occupied"), py::arg("radius"), py::arg("resolution"), without_gil(),
        "Cells whose centre lies within `radius` [m] of an occupied centre: (H, W) bool -> (H, W) bool. ValueError for "
        "an empty mask, a negative radius or a resolution [m] that is not positive.");
}

void bind_ray_casting(py::module_& m) {
  using Angles = py::array_t<double, py::array::c_style | py::array::forcecast>;
  py::class_<RayCaster>(
      m, "RayCaster",
      "Exact ray casting in a map: the distance to the entry into the first cell occupied from 65 % on, as a walk from "
      "cell to cell finds it. Unknown cells are transparent. Takes 4 bytes a cell.")
      .def(py::init<const OccupancyGrid&, double>(), py::arg("grid"), py::arg("range_max"), without_gil())
      .def(
          "cast",
          [](const RayCaster& caster, const Pose2& T_map_laser, const Angles& angles) {
            if (angles.ndim() != 1)
              throw std::invalid_argument("angles has " + std::to_string(angles.ndim()) +
                                          " dimensions, must have 1: (B,)");
            py::array_t<float> ranges(angles.size());
            const std::span<const double> from(angles.data(), angles.size());
            const std::span<float> to(ranges.mutable_data(), angles.size());
            py::gil_scoped_release release;
            caster.cast(T_map_laser, from, to);
            return ranges;
          },
          py::arg("T_map_laser"), py::arg("angles"),
          "Ranges (B,) float32 [m] at angles (B,) [rad] in the laser's frame: 0 if the laser is in an occupied cell, "
          "inf if nothing is hit within range_max or before the map's end. ValueError for a pose or angle that is not "
          "finite.")
      .def_property_readonly("range_max", &RayCaster::range_max, "[m]");
}

void bind_heatmap_map(py::module_& m) {
  py::class_<HeatmapMap>(
      m, "HeatmapMap",
      "Local heatmaps put together along a drive (Alg. 4), over a map: the mean heat of each cell over all frames that "
      "saw it. Several cells of a frame that fall into one cell of the map all count (ERRATA 32).")
      .def(py::init<const OccupancyGrid&>(), py::arg("map"))
      .def("insert", &HeatmapMap::insert, py::arg("heatmap"), py::arg("visible"), py::arg("T_map_base"), without_gil(),
           "Adds the visible cells (100, 100) bool of a local heatmap (100, 100), scaled to a maximum of 1 among them. "
           "A frame without heat counts as seen, with heat 0. Returns the number of visible cells that lay outside the "
           "map. ValueError, and no change, for other shapes, heat that is negative or not finite, or a pose that is "
           "not.")
      .def("heatmap", &HeatmapMap::heatmap, without_gil(),
           "H_concat (H, W) float32: mean heat in [0, 1]; 0 where no frame saw the cell.")
      .def_property_readonly(
          "count", [](const HeatmapMap& map) -> const GridOf<std::int32_t>& { return map.count(); },
          py::return_value_policy::reference_internal, "C (H, W) int32, a view: how many local cells fell into each");
}

}  // namespace

void bind_grid(py::module_& m) {
  bind_occupancy_grid(m);
  bind_laser_scan(m);
  bind_obstacle_points(m);
  bind_read_beams(m);
  bind_scan_mapping(m);
  bind_rolling_map(m);
  bind_distance_field(m);
  bind_ray_casting(m);
  bind_heatmap_map(m);
}

}  // namespace lfdcore
