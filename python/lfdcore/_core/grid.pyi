"""
Occupancy grids, scans, distance fields and ray casting.
"""

from __future__ import annotations
import collections.abc
import lfdcore._core.geometry
import numpy
import numpy.typing
import typing

__all__: list[str] = [
    "HeatmapMap",
    "LaserScan",
    "ObstaclePoints",
    "OccupancyGrid",
    "RayCaster",
    "RollingMap",
    "distance_field",
    "inflate",
    "local_grid",
    "read_beams",
]

class OccupancyGrid:
    """
    Cells (height, width) of int8: 0 free .. 100 occupied [%], -1 unknown; data[iy, ix]. The origin [m] is the corner of cell (0, 0) in the grid's frame (nav_msgs/OccupancyGrid).
    """

    def __init__(
        self, data: numpy.typing.ArrayLike, resolution: float, origin: tuple[float, float] = (0.0, 0.0)
    ) -> None: ...
    def cell_at(self, x: float, y: float) -> tuple[int, int]:
        """
        (ix, iy) of the cell that holds a point [m]; may lie outside the grid.
        """

    def centre(self, ix: int, iy: int) -> numpy.typing.NDArray[numpy.float64]:
        """
        (2,) centre of a cell [m]
        """

    def occupied_mask(self) -> numpy.typing.NDArray[numpy.bool]:
        """
        (height, width) bool: true from 65 % on
        """

    @property
    def data(self) -> numpy.typing.NDArray[numpy.int8]:
        """
        (height, width) int8, a view
        """

    @property
    def height(self) -> int:
        """
        rows
        """

    @property
    def origin(self) -> tuple[float, float]:
        """
        (x, y) [m] of the corner of cell (0, 0)
        """

    @property
    def resolution(self) -> float:
        """
        [m]
        """

    @property
    def width(self) -> int:
        """
        columns
        """

class LaserScan:
    """
    One sweep of a planar LIDAR (sensor_msgs/LaserScan): ranges (B,) [m], where +inf = nothing within range_max, -inf = closer than range_min, NaN = no measurement (REP-117; read_beams); angles [rad] in the laser's frame. A broken scanner may give a scan without beams.
    """

    def __init__(
        self,
        ranges: collections.abc.Sequence[float],
        angle_min: float,
        angle_increment: float,
        range_min: float = 0.0,
        range_max: float = 30.0,
    ) -> None: ...
    def angles(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (B,) [rad] in the laser's frame
        """

    @property
    def angle_increment(self) -> float:
        """
        [rad]
        """

    @property
    def angle_min(self) -> float:
        """
        [rad] of beam 0
        """

    @property
    def range_max(self) -> float:
        """
        [m]
        """

    @property
    def range_min(self) -> float:
        """
        [m]
        """

    @property
    def ranges(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        (B,) float32 [m], a view
        """

class ObstaclePoints:
    """
    Obstacles as points (M, 2) [m] that a LIDAR saw, all in one frame; exact clearance of a rectangular body from them.

    uncertainty (M,) [m], 0 to 100: how much nearer than its point each obstacle may be, e.g. some standard errors of a fused range; empty: 0 for all. The supervisor keeps that much more distance; collides() and clearance() are about the points alone.
    ValueError for points that are not finite, and for uncertainties out of their bounds or not as many as the points.
    """

    def __init__(self, points: numpy.typing.ArrayLike, uncertainty: numpy.typing.ArrayLike = ...) -> None: ...
    def __len__(self) -> int:
        """
        number of points
        """

    def clearance(self, pose: lfdcore._core.geometry.Pose2, footprint: lfdcore._core.geometry.Footprint) -> float:
        """
        Distance [m] from the footprint's edge to the nearest point; 0 if one lies inside, inf without points. ValueError if pose or footprint is not finite.
        """

    def collides(self, pose: lfdcore._core.geometry.Pose2, footprint: lfdcore._core.geometry.Footprint) -> bool:
        """
        True if any point lies inside or on the footprint of a body at `pose`. ValueError if either is not finite.
        """

    @property
    def points(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (M, 2) [m], a view
        """

    @property
    def uncertainty(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (M,) [m], a view
        """

class RollingMap:
    """
    A map of recent scans around the robot, aligned with the odometry frame, for what the LIDAR no longer sees.

    Hits that agree become one point, their mean. A point is remembered for `duration` [s]; it is forgotten earlier
    when beams go on behind it, and 3 s after its last hit where a person stepped into space that had just been seen
    empty and did not stay there for 3 s.

    radius [m], 0.5 to 20: how far from the robot obstacles() looks. range_noise [m], 0.001 to 0.2: standard deviation
    of a range. odometry_error, 0 to 0.5: share of way and turn by which the odometry may be wrong. own_body: the
    robot's outline; hits deeper inside it than 0.03 m are its own, and what it stood on counts as seen.
    ValueError for values out of these bounds.
    """

    own_depth: typing.ClassVar[float] = 0.03

    def __init__(
        self,
        duration: float = 30.0,
        radius: float = 4.0,
        range_noise: float = 0.01,
        odometry_error: float = 0.0,
        own_body: lfdcore._core.geometry.Footprint | None = None,
    ) -> None: ...
    def __len__(self) -> int:
        """
        number of points remembered
        """

    def clear(self) -> None:
        """
        Forgets everything, stamps included.
        """

    def insert(
        self,
        stamp: float,
        scan: LaserScan,
        T_base_laser: lfdcore._core.geometry.Pose2,
        T_odom_base: lfdcore._core.geometry.Pose2,
    ) -> None:
        """
        Adds a scan taken at `stamp` [s] from T_odom_base; one without beams is as one whose beams all measured nothing. ValueError, and no change, for an invalid scan or pose or a stamp before the last one.
        """

    def local_grid(self, T_odom_base: lfdcore._core.geometry.Pose2) -> OccupancyGrid:
        """
        The window around base_link -> OccupancyGrid (100 x 100 of 0.05 m): occupied where a remembered point lies, else free where seen free within `duration`, else -1.
        """

    def obstacles(self, T_odom_base: lfdcore._core.geometry.Pose2) -> ObstaclePoints:
        """
        The remembered points within `radius` of base_link, in base_link, each with 3 standard errors as its
        uncertainty -> ObstaclePoints. With an odometry_error, what the last scan did not hit is given with the ends
        of where it may lie by now: the share of the way driven since, and of the turns, moves it.
        """

    def unseen(
        self, T_odom_base: lfdcore._core.geometry.Pose2, body: lfdcore._core.geometry.Footprint, reach: float
    ) -> ObstaclePoints:
        """
        The edge of the space that nothing is known of -> ObstaclePoints in base_link: centres of 0.05 m cells that no
        beam has passed or ended in within `duration`, beside known ones, no farther from the outline of `body` than
        `reach` [m], 0 to 20. What lies under the body is known, and what was under own_body in any scan. Gaps of
        less than 0.25 m count as seen. ValueError for a pose or body that is not finite, or a reach out of bounds.
        """

    def walkers(self, T_odom_base: lfdcore._core.geometry.Pose2) -> ObstaclePoints:
        """
        The points of what walks, as the newest scan hit them -> ObstaclePoints in base_link. obstacles() holds them too.
        """

    @property
    def duration(self) -> float:
        """
        [s]
        """

    @property
    def odometry_error(self) -> float:
        """
        share
        """

    @property
    def own_body(self) -> lfdcore._core.geometry.Footprint | None:
        """
        Footprint or None
        """

    @property
    def radius(self) -> float:
        """
        [m]
        """

    @property
    def range_noise(self) -> float:
        """
        [m]
        """

class RayCaster:
    """
    Exact ray casting in a map: the distance to the entry into the first cell occupied from 65 % on, as a walk from cell to cell finds it. Unknown cells are transparent. Takes 4 bytes a cell.
    """

    def __init__(self, grid: OccupancyGrid, range_max: float) -> None: ...
    def cast(
        self, T_map_laser: lfdcore._core.geometry.Pose2, angles: numpy.typing.ArrayLike
    ) -> numpy.typing.NDArray[numpy.float32]:
        """
        Ranges (B,) float32 [m] at angles (B,) [rad] in the laser's frame: 0 if the laser is in an occupied cell, inf if nothing is hit within range_max or before the map's end. ValueError for a pose or angle that is not finite.
        """

    @property
    def range_max(self) -> float:
        """
        [m]
        """

class HeatmapMap:
    """
    Local heatmaps put together along a drive (Alg. 4), over a map: the mean heat of each cell over all frames that saw it. Several cells of a frame that fall into one cell of the map all count (ERRATA 32).
    """

    def __init__(self, map: OccupancyGrid) -> None: ...
    def heatmap(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        H_concat (H, W) float32: mean heat in [0, 1]; 0 where no frame saw the cell.
        """

    def insert(
        self, heatmap: numpy.typing.ArrayLike, visible: numpy.typing.ArrayLike, T_map_base: lfdcore._core.geometry.Pose2
    ) -> int:
        """
        Adds the visible cells (100, 100) bool of a local heatmap (100, 100), scaled to a maximum of 1 among them. A frame without heat counts as seen, with heat 0. Returns the number of visible cells that lay outside the map. ValueError, and no change, for other shapes, heat that is negative or not finite, or a pose that is not.
        """

    @property
    def count(self) -> numpy.typing.NDArray[numpy.int32]:
        """
        C (H, W) int32, a view: how many local cells fell into each
        """

def distance_field(occupied: numpy.typing.ArrayLike, resolution: float) -> numpy.typing.NDArray[numpy.float32]:
    """
    Distance from each cell's centre to the nearest occupied centre: (H, W) bool -> (H, W) float32 [m], inf if no cell is occupied. Exact (Felzenszwalb & Huttenlocher 2012). ValueError for an empty mask or a resolution [m] that is not positive.
    """

def inflate(occupied: numpy.typing.ArrayLike, radius: float, resolution: float) -> numpy.typing.NDArray[numpy.bool]:
    """
    Cells whose centre lies within `radius` [m] of an occupied centre: (H, W) bool -> (H, W) bool. ValueError for an empty mask, a negative radius or a resolution [m] that is not positive.
    """

def local_grid(scan: LaserScan, T_base_laser: lfdcore._core.geometry.Pose2) -> OccupancyGrid:
    """
    What one scan shows of the window around base_link -> OccupancyGrid of 100 x 100 cells of 0.05 m (Sec. 3.3).

    Cells along a beam are free (0), the cell at its end is occupied (100, which wins), all others unknown (-1);
    only the edges of obstacles are seen. What a range means: see read_beams.
    ValueError for an invalid scan or a pose that is not finite.
    """

@typing.overload
def read_beams(
    ranges: numpy.typing.ArrayLike, range_min: float, range_max: float
) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.bool]]:
    """
    What ranges mean (REP-117) -> lengths float64 [m], hit bool, both of the shape of `ranges`.

    ranges (..., B) float32 [m]: of one scan or of many; range_min, range_max [m] of the scanner. The space
    along a beam is free up to its length; if it hit, something is there:

    - finite, in [range_min, range_max): a hit there (with a range_min of 0, 0 is a hit at the laser);
    - +inf, or at least range_max: free up to range_max, no hit;
    - -inf: closer than the scanner can tell, taken to be a hit at range_min;
    - NaN, or finite and below range_min: nothing was measured: length 0, no hit.

    ValueError unless 0 <= range_min <= 1000 m and range_min < range_max, finite; for ranges without a dimension.
    TypeError for ranges that are no real numbers: text, complex numbers, objects.
    """

@typing.overload
def read_beams(scan: LaserScan) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.bool]]:
    """
    The same of one scan -> lengths (B,) float64 [m], hit (B,) bool.
    """
