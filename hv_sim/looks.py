"""How a scene looks otherwise: lights, colours, textures and the camera's place, drawn anew for every recording.

Only what is drawn changes, never the model: a `Look` alters MuJoCo's abstract scene (`mujoco.MjvScene`) between its
update and its rendering. What a thing is called by, its colour among others, stays true.
"""

from __future__ import annotations

import os
from dataclasses import asdict, dataclass, fields

import mujoco
import numpy as np
import yaml

_GEOM, _PLANE = mujoco.mjtObj.mjOBJ_GEOM, mujoco.mjtGeom.mjGEOM_PLANE


@dataclass(frozen=True)
class LookRanges:
    """How far looks may differ; all zeros for none.

    Args:
        light: standard deviation of the logarithm of each light's strength.
        light_tint: the same for red, green and blue of all light together.
        thing_tint: the same for red, green and blue of each colour of furniture and things.
        surface_blend: most that floor and walls are blended with any colour, 0..1.
        plain_share: how often a texture is left out, 0..1.
        camera_m: standard deviation of the camera's place along each axis, m.
        camera_rad: the same of its direction, rad.

    Raises:
        ValueError: a value is negative, not finite, or a share above 1.
    """

    light: float = 0.0
    light_tint: float = 0.0
    thing_tint: float = 0.0
    surface_blend: float = 0.0
    plain_share: float = 0.0
    camera_m: float = 0.0
    camera_rad: float = 0.0

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            most = 1.0 if name in ("surface_blend", "plain_share") else 0.5
            if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value <= most:
                raise ValueError(f"looks: {name} {value!r} is not valid; valid: 0 to {most:g}")

    @property
    def vary(self) -> bool:
        return any(asdict(self).values())


NO_LOOKS = LookRanges()


def read_look_ranges(path: str | os.PathLike[str]) -> LookRanges:
    """The ranges in a YAML file (`configs/looks.yaml`).

    Raises:
        ValueError: it cannot be read, or holds something else; one line.
    """
    try:
        with open(path, encoding="utf-8") as file:
            values = yaml.safe_load(file)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise ValueError(f"looks: {path} cannot be read: {' '.join(str(error).split())}") from error
    names = [field.name for field in fields(LookRanges)]
    if not isinstance(values, dict) or not set(values) <= set(names):
        wrong = sorted(map(str, set(values) - set(names))) if isinstance(values, dict) else [type(values).__name__]
        raise ValueError(f"looks: {path} holds {', '.join(wrong)}; valid: {', '.join(names)}")
    return LookRanges(**values)


class Look:
    """One way to look, drawn from ranges.

    Args:
        ranges: how far it may differ.
        rng: decides everything.
    """

    def __init__(self, ranges: LookRanges, rng: np.random.Generator) -> None:
        self._ranges = ranges
        self._seed = int(rng.integers(2**31))
        self._known: dict[tuple[bytes, bool, int], tuple[np.ndarray, bool]] = {}
        self._lights = np.exp(ranges.light * rng.standard_normal(16))
        self._light_tint = np.exp(ranges.light_tint * rng.standard_normal(3))
        self._shift_m = ranges.camera_m * rng.standard_normal(3)
        self._turn_rad = ranges.camera_rad * rng.standard_normal(3)

    def alter(self, scene: mujoco.MjvScene, model: mujoco.MjModel) -> None:
        """Alters a scene that was just updated from a model's state."""
        for i in range(scene.nlight):
            light = scene.lights[i]
            gain = self._lights[i % len(self._lights)] * self._light_tint
            light.ambient, light.diffuse = light.ambient * gain, light.diffuse * gain
        # what it does to a colour depends on that colour alone: the parts of a thing go on belonging together
        for geom in scene.geoms[: scene.ngeom]:
            if geom.objtype != _GEOM or geom.rgba[3] == 0.0:
                continue
            is_surface = geom.type == _PLANE and model.geom_bodyid[geom.objid] == 0
            key = (geom.rgba.tobytes(), is_surface, geom.matid)
            if key not in self._known:
                self._known[key] = self._drawn(geom.rgba[:3], is_surface, geom.matid)
            geom.rgba[:3], is_plain = self._known[key]
            if is_plain:
                geom.matid = -1
                geom.texid = -1
        for camera in scene.camera:
            self._move(camera)

    def _drawn(self, color: np.ndarray, is_surface: bool, material: int) -> tuple[np.ndarray, bool]:
        """What becomes of a colour, and whether its texture is left out."""
        numbers = np.round(np.array([*color, is_surface, material]) * 4096).astype(np.int64) & 0xFFFFFFFF
        rng = np.random.default_rng([self._seed, *numbers.tolist()])
        drawn = self._surface(color, rng) if is_surface else self._thing(color, rng)
        return drawn, bool(rng.random() < self._ranges.plain_share)

    def _surface(self, color: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        share = rng.uniform(0.0, self._ranges.surface_blend)
        return (1 - share) * color + share * rng.uniform(0.1, 1.0, 3)

    def _thing(self, color: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        return np.clip(color * np.exp(self._ranges.thing_tint * rng.standard_normal(3)), 0.0, 1.0)

    def _move(self, camera: mujoco.MjvGLCamera) -> None:
        forward, up = np.array(camera.forward, float), np.array(camera.up, float)
        axes = np.stack([forward, np.cross(up, forward), up])
        camera.pos = np.array(camera.pos) + self._shift_m @ axes
        turn = np.empty(4)
        angle = float(np.linalg.norm(self._turn_rad))
        mujoco.mju_axisAngle2Quat(turn, self._turn_rad / max(angle, 1e-12) @ axes, angle)
        for name, axis in (("forward", forward), ("up", up)):
            turned = np.empty(3)
            mujoco.mju_rotVecQuat(turned, axis, turn)
            setattr(camera, name, turned)
