"""Worlds to drive in, drawn by us, each with a reference route; docs/courses.md shows and lists them."""

from lfdcore.study.courses.any_map import from_map
from lfdcore.study.courses.catalogue import course_by_name, course_names, training_courses, tuning_courses
from lfdcore.study.courses.course import Course
from lfdcore.study.courses.drawing import Door, Drawing
from lfdcore.study.courses.goal_building import GoalWorld, Spread, goal_building, goals_in_map
from lfdcore.study.courses.held_out import campus, figure_eight, standard_course
from lfdcore.study.courses.homes import HOME_ROUTES, flat, home, office
from lfdcore.study.courses.ideal import FootprintOnGrid, IdealDrive, drive_ideally
from lfdcore.study.courses.large_home import home_20x19
from lfdcore.study.courses.mazes import MAZE_ROUTES, maze_1, maze_2, mazes
from lfdcore.study.courses.roomy import hall
from lfdcore.study.courses.routes import RouteConfig, RoutePlanner, clearance_field, route_clearance
from lfdcore.study.courses.tasks import DOCKING_DISTANCE, Task, distance_to_box, doorway_and_docking, narrow_gap

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
