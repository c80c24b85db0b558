"""Tops that things can be put on: where they are, how high, and from where a robot reaches them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from hv_sim.furniture import FURNITURE_KINDS
from hv_sim.task import FurniturePlacement

REACHABLE_M = (0.1, 0.92)
"""Heights of tops that the robot can put things on."""


@dataclass(frozen=True)
class Surface:
    """A free rectangle on top of a piece of furniture; world frame, metres.

    Attributes:
        furniture: name of the piece.
        kind: its kind.
        position_m: (x, y) of the middle of the rectangle.
        yaw_rad: where the piece's front looks.
        depth_m: extent along the front's direction.
        width_m: extent across it.
        height_m: of the top above the floor.
        edges_m: how far the piece itself reaches from the middle to its front, back, left and right.
    """

    furniture: str
    kind: str
    position_m: tuple[float, float]
    yaw_rad: float
    depth_m: float
    width_m: float
    height_m: float
    edges_m: tuple[float, float, float, float]

    def point_m(self, ahead_m: float, left_m: float) -> tuple[float, float]:
        """World (x, y) of a point: ahead toward the piece's front and to the left, seen from the piece."""
        c, s = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        x, y = self.position_m
        return float(x + c * ahead_m - s * left_m), float(y + s * ahead_m + c * left_m)

    def sides(self) -> tuple[tuple[float, float, float, float], ...]:
        """Front, back, left and right: (outward yaw, distance of the piece's edge, half extents toward it and across).

        All of the rectangle, seen from its middle, but for the edge, behind which the robot has to stay.
        """
        deep, wide = self.depth_m / 2, self.width_m / 2
        front, back, left, right = self.edges_m
        return (
            (self.yaw_rad, front, deep, wide),
            (self.yaw_rad + np.pi, back, deep, wide),
            (self.yaw_rad + np.pi / 2, left, wide, deep),
            (self.yaw_rad - np.pi / 2, right, wide, deep),
        )


def surfaces_of(furniture: Iterable[FurniturePlacement]) -> list[Surface]:
    """The tops among these pieces that are meant for putting things on and that the robot can reach."""
    found = []
    for piece in furniture:
        spec = FURNITURE_KINDS[piece.kind]
        if not spec.holds_objects:
            continue
        depth, width, height = spec.size_m if piece.size_m is None else piece.size_m
        back, front, right, left = spec.top
        if not REACHABLE_M[0] <= height <= REACHABLE_M[1]:
            continue
        c, s = np.cos(piece.yaw_rad), np.sin(piece.yaw_rad)
        ahead, aside = depth * (back + front) / 2, width * (right + left) / 2
        at = (piece.position_m[0] + c * ahead - s * aside, piece.position_m[1] + s * ahead + c * aside)
        found.append(
            Surface(
                furniture=piece.name,
                kind=piece.kind,
                position_m=(float(at[0]), float(at[1])),
                yaw_rad=piece.yaw_rad,
                depth_m=float(depth * (front - back)),
                width_m=float(width * (left - right)),
                height_m=float(height),
                edges_m=(depth / 2 - ahead, depth / 2 + ahead, width / 2 - aside, width / 2 + aside),
            )
        )
    return found
