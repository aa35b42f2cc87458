"""A contact of the simulated chair with a person, with what is needed to judge it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot, inf

from lfdcore.simulation import PersonContact

STANDING = 0.02
"""Speed [m/s] below which a part of the chair counts as standing."""
WARNING = 1.0
"""A scan warns of a contact if it showed the person at least so long before [s] ..."""
FORGOTTEN = 1.5
"""... and no longer: who has been out of view since then comes unforeseen."""


@dataclass(frozen=True)
class PersonMet:
    """What was so when the contact began. Nobody gives way: the chair drives and the person walks on."""

    person: int
    """its place among the people"""
    stamp: float
    """[s]"""
    part: str
    """of the outline: 'nose', 'left', 'right' or 'rear'; a corner belongs to the nose or the rear"""
    point: tuple[float, float]
    """the outline's point that was met, in base_link [m]"""
    chair_speed: float
    """of that point [m/s]"""
    chair_approach: float
    """of that point towards the person [m/s]"""
    person_approach: float
    """of the person towards that point [m/s]"""
    chair_approach_since: float
    """the largest chair_approach while they touched, until the person's centre was inside the outline [m/s]"""
    shown_before: float
    """Age [s] of the newest scan, at least WARNING old, in which a beam met the person; inf if none did."""

    @property
    def was_shown(self) -> bool:
        """Whether a scan showed the person about a second before: from FORGOTTEN to WARNING."""
        return self.shown_before <= FORGOTTEN

    @property
    def walked_into_standing_chair(self) -> bool:
        """The chair stood there and the person came."""
        return self.chair_speed < STANDING and self.person_approach > 0

    @property
    def by_moving_nose(self) -> bool:
        """The chair's nose moved towards the person."""
        return self.part == "nose" and self.chair_approach >= STANDING

    @property
    def foreseeable(self) -> bool:
        """The moving chair's nose met a person whom a scan had shown a second before: what an assistant answers for."""
        return self.by_moving_nose and self.was_shown


def person_met(contact: PersonContact, shown: Sequence[tuple[float, Sequence[bool]]]) -> PersonMet:
    """shown: stamp [s] of each scan so far, and of each person whether a beam met it."""
    x, y = contact.point
    linear, angular = contact.twist
    due = contact.stamp - WARNING + 1e-9
    at = next((stamp for stamp, met in reversed(shown) if stamp <= due and met[contact.person]), -inf)
    return PersonMet(
        person=contact.person,
        stamp=contact.stamp,
        part=contact.part,
        point=(float(x), float(y)),
        chair_speed=hypot(linear - angular * y, angular * x),
        chair_approach=contact.chair_approach,
        person_approach=contact.person_approach,
        chair_approach_since=contact.chair_approach_since,
        shown_before=contact.stamp - at,
    )
