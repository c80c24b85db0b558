"""Furniture: what stands still in a room, made of upright boxes and cylinders for contact and finer parts to look at.

A piece's frame lies on the floor under the middle of its footprint; its front faces +x and its width runs along y.
"""

from __future__ import annotations

from hv_sim.furniture_kinds.bedroom import BEDROOM
from hv_sim.furniture_kinds.kind import Size
from hv_sim.furniture_kinds.kitchen import KITCHEN
from hv_sim.furniture_kinds.living import LIVING
from hv_sim.furniture_kinds.made_up import COUNT, PREFIX, made_up_piece
from hv_sim.furniture_kinds.warehouse import WAREHOUSE
from hv_sim.kinds import Kinds
from hv_sim.parts import COLORS, Part

FURNITURE_KINDS = Kinds({**LIVING, **BEDROOM, **KITCHEN, **WAREHOUSE}, PREFIX, COUNT, made_up_piece)
"""Kinds that a task file may name: those of the package, and made-up ones (`hv_sim.furniture_kinds.made_up`)."""


def build_furniture(kind: str, size_m: Size | None = None, color: str | None = None) -> list[Part]:
    """Parts of a piece of a kind in `FURNITURE_KINDS`; what is left out takes the kind's usual value.

    Raises:
        ValueError: `size_m: ...` less than half or more than twice the kind's usual size along some axis.
        KeyError: an unknown kind or colour.
    """
    spec = FURNITURE_KINDS[kind]
    size = spec.size_m if size_m is None else (float(size_m[0]), float(size_m[1]), float(size_m[2]))
    if not all(0.5 * usual - 1e-9 <= s <= 2.0 * usual + 1e-9 for s, usual in zip(size, spec.size_m, strict=True)):
        usual = ", ".join(f"{0.5 * s:g} to {2.0 * s:g}" for s in spec.size_m)
        raise ValueError(f"size_m: {list(size)} is not a {kind}'s size (depth, width, height); valid: {usual}")
    return spec.build(size, COLORS[spec.color if color is None else color])
