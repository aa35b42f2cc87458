"""What a drive log looks like, and what is wrong with it, in words that say what to do."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.drive_log import DriveLog
from lfdcore.datasets.motion import odometry_jumps
from lfdcore.geometry import arc_length
from lfdcore.grid import read_beams

LONG_GAP = 1.0
"""[s] without a record that is worth a word, and ..."""
PERIODS = 10.0
"""... so many times the stream's usual period"""
FEW_RETURNS = 0.02
"""share of beams that return, below which a scanner hardly sees anything"""
NEAR = 0.5
"""Most beams that end nearer than this [m] end on the robot itself"""


def log_facts(log: DriveLog) -> dict[str, Any]:
    """What its streams are, by stable names and plain numbers; `wrong` lists what `log_troubles` finds."""
    lengths, hit = read_beams(log.ranges, log.range_min, log.range_max)
    mounting = log.T_base_laser
    return {
        "duration [s]": round(log.duration, 3),
        "scans": _stream(log.scan_stamp)
        | {
            "beams": int(log.ranges.shape[1]),
            "range_max [m]": round(log.range_max, 3),
            "returning": round(float(hit.mean()), 3) if hit.size else 0.0,
            "median [m]": round(float(np.median(lengths[hit])), 3) if hit.any() else None,
        },
        "scanner at": "unknown"
        if mounting is None
        else {"x [m]": mounting.x, "y [m]": mounting.y, "yaw [deg]": round(float(np.degrees(mounting.yaw)), 6)}
        | {"upside down": log.angle_increment < 0},
        "odometry": _stream(log.odometry_stamp)
        | {
            "way [m]": round(float(arc_length(log.pose[:, :2])[-1]), 2) if len(log.pose) else 0.0,
            "jumps": int(odometry_jumps(log).sum()),
        },
        "joystick": _stream(log.joystick_stamp),
        "commands": _stream(log.command_stamp),
        "plans": len(log.plans),
        "wrong": log_troubles(log),
    }


def log_troubles(log: DriveLog) -> list[str]:
    """Sentences, the gravest first; each says what to do about it."""
    found = [_about_mounting(log), *_about_ranges(log), *_about_odometry(log), *_about_gaps(log), _about_joystick(log)]
    found += [f"{name.removesuffix(' left out')}: {note}" for name, note in log.metadata.items() if "left out" in name]
    return [one for one in found if one]


def _stream(stamps: NDArray[np.float64]) -> dict[str, Any]:
    gaps = np.diff(stamps)
    usual = float(np.median(gaps)) if len(gaps) else 0.0
    return {
        "records": len(stamps),
        "rate [Hz]": round(1 / usual, 2) if usual > 0 else None,
        "longest gap [s]": round(float(gaps.max()), 3) if len(gaps) else None,
    }


def _about_mounting(log: DriveLog) -> str:
    if log.T_base_laser is not None:
        return ""
    why = log.metadata.get("T_base_laser", "unknown").removeprefix("unknown: ").partition(";")[0]
    return f"nobody knows where the scanner is ({why}): measure it, and say --mounting X,Y,YAW"


def _about_ranges(log: DriveLog) -> list[str]:
    lengths, hit = read_beams(log.ranges, log.range_min, log.range_max)
    if not hit.size:
        return ["there is no scan"]
    if hit.mean() < FEW_RETURNS:
        return [
            f"{100 * hit.mean():.1f} % of the beams return: are the ranges in metres, and is range_max "
            f"{log.range_max:g} m?"
        ]
    near = float((lengths[hit] < NEAR).mean())
    if near > 0.5:
        return [f"{100 * near:.0f} % of the beams end nearer than {NEAR:g} m: on the robot itself?"]
    return []


def _about_odometry(log: DriveLog) -> list[str]:
    found = []
    jumps = np.flatnonzero(odometry_jumps(log))
    if len(jumps):
        k = jumps[0]
        x, y, yaw = log.pose[k] - log.pose[k - 1]
        found.append(
            f"odometry jumps {len(jumps)} times, first by {np.hypot(x, y):.2f} m and {yaw:.2f} rad at "
            f"{log.odometry_stamp[k]:.2f} s: no path is learned across it"
        )
    if len(log.odometry_stamp) and len(log.scan_stamp):
        inside = (log.scan_stamp >= log.odometry_stamp[0]) & (log.scan_stamp <= log.odometry_stamp[-1])
        if inside.mean() < 0.9:
            share = 100 * (1 - inside.mean())
            found.append(f"{share:.0f} % of the scans have no odometry around them: they are not used")
    if len(log.odometry_stamp) == 0:
        found.append("there is no odometry: say --odometry TOPIC, or tf")
    return found


def _about_gaps(log: DriveLog) -> list[str]:
    found = []
    for name, stamps in (("scans", log.scan_stamp), ("odometry", log.odometry_stamp), ("joystick", log.joystick_stamp)):
        gaps = np.diff(stamps)
        usual = float(np.median(gaps)) if len(gaps) else 0.0
        long = gaps > max(LONG_GAP, PERIODS * usual)
        if long.any():
            at = stamps[int(np.argmax(gaps))]
            found.append(f"{name} pause {int(long.sum())} times, longest for {gaps.max():.2f} s from {at:.2f} s on")
    return found


def _about_joystick(log: DriveLog) -> str:
    if not len(log.joystick_stamp):
        return "no joystick was recorded: learning infers it from the motion"
    if not np.abs(log.joystick).max() > 0:
        return "the joystick never left its centre: are these its axes? say --axes FORWARD,LEFT"
    return ""
