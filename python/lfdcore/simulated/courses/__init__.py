"""Worlds to drive in, drawn by us, each with a reference route; docs/courses.md shows and lists them."""

from lfdcore.simulated.courses.any_map import from_map
from lfdcore.simulated.courses.catalogue import course_by_name, course_names, training_courses, tuning_courses
from lfdcore.simulated.courses.course import Course
from lfdcore.simulated.courses.drawing import Door, Drawing
from lfdcore.simulated.courses.goal_building import GoalWorld, Spread, goal_building, goals_in_map
from lfdcore.simulated.courses.held_out import campus, figure_eight, standard_course
from lfdcore.simulated.courses.homes import HOME_ROUTES, flat, home, office
from lfdcore.simulated.courses.ideal import FootprintOnGrid, IdealDrive, drive_ideally
from lfdcore.simulated.courses.large_home import home_20x19
from lfdcore.simulated.courses.mazes import MAZE_ROUTES, maze_1, maze_2, mazes
from lfdcore.simulated.courses.roomy import hall
from lfdcore.simulated.courses.routes import RouteConfig, RoutePlanner, clearance_field, route_clearance
from lfdcore.simulated.courses.tasks import DOCKING_DISTANCE, Task, distance_to_box, doorway_and_docking, narrow_gap

__all__ = [
    "DOCKING_DISTANCE",
    "HOME_ROUTES",
    "MAZE_ROUTES",
    "Course",
    "Door",
    "Drawing",
    "FootprintOnGrid",
    "GoalWorld",
    "IdealDrive",
    "RouteConfig",
    "RoutePlanner",
    "Spread",
    "Task",
    "campus",
    "clearance_field",
    "course_by_name",
    "course_names",
    "distance_to_box",
    "doorway_and_docking",
    "drive_ideally",
    "figure_eight",
    "flat",
    "from_map",
    "goal_building",
    "goals_in_map",
    "hall",
    "home",
    "home_20x19",
    "maze_1",
    "maze_2",
    "mazes",
    "narrow_gap",
    "office",
    "route_clearance",
    "standard_course",
    "training_courses",
    "tuning_courses",
]
