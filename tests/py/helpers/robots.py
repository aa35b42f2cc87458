"""Robots that the tests write down themselves."""

import numpy as np
from numpy.typing import NDArray

UR5_DH = (
    # a [m], d [m], alpha [rad]: Universal Robots' published Denavit-Hartenberg parameters of the UR5
    (0.0, 0.089159, np.pi / 2),
    (-0.425, 0.0, 0.0),
    (-0.39225, 0.0, 0.0),
    (0.0, 0.10915, np.pi / 2),
    (0.0, 0.09465, -np.pi / 2),
    (0.0, 0.0823, 0.0),
)


def joint(
    name: str, parent: str, child: str, *, kind: str = "revolute", origin: str = "", limit: str | None = None
) -> str:
    bounds = '<limit lower="-3" upper="3" velocity="3" effort="1"/>' if limit is None else limit
    return (
        f'<joint name="{name}" type="{kind}"><origin {origin}/><parent link="{parent}"/><child link="{child}"/>'
        f'<axis xyz="0 0 1"/>{bounds}</joint>'
    )


def robot(*parts: str, links: tuple[str, ...] = ()) -> str:
    return '<robot name="r">' + "".join(f'<link name="{link}"/>' for link in links) + "".join(parts) + "</robot>"


def ur5_urdf() -> str:
    """Each joint turns about z of the last DH frame; the step from frame to frame is the next joint's origin."""
    parts, origin = [], 'xyz="0 0 0" rpy="0 0 0"'
    for i, (a, d, alpha) in enumerate(UR5_DH):
        parts.append(joint(f"j{i}", f"l{i}", f"l{i + 1}", origin=origin))
        origin = f'xyz="{a} 0 {d}" rpy="{alpha!r} 0 0"'
    parts.append(joint("flange", "l6", "tool0", kind="fixed", origin=origin, limit=""))
    return robot(*parts, links=(*(f"l{i}" for i in range(7)), "tool0"))


def ur5_forward(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """(4, 4) by the DH convention: turn about z, shift along z, shift along x, turn about x."""
    T = np.eye(4)
    for angle, (a, d, alpha) in zip(q, UR5_DH, strict=True):
        c, s, ca, sa = np.cos(angle), np.sin(angle), np.cos(alpha), np.sin(alpha)
        T = T @ np.array([[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]])
    return T
