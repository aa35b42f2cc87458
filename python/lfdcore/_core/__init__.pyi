"""
lfdcore's C++ core; import it through lfdcore.grid, .planning, .control, .estimation, .primitives, .kinematics and .simulation.
"""

from __future__ import annotations
from . import geometry
from . import grid
from . import simulation
from . import planning
from . import control
from . import estimation
from . import primitives
from . import kinematics
from . import hardware

__all__: list[str] = [
    "DataError",
    "DeviceError",
    "ModelError",
    "control",
    "estimation",
    "geometry",
    "grid",
    "hardware",
    "kinematics",
    "planning",
    "primitives",
    "simulation",
]

class DataError(RuntimeError):
    pass

class ModelError(RuntimeError):
    pass

class DeviceError(RuntimeError):
    pass
