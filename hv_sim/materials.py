"""Materials: how surfaces look. Small textures drawn by numpy from fixed seeds, so that nothing is downloaded."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache

import mujoco
import numpy as np


@dataclass(frozen=True)
class Material:
    """How a surface answers light.

    Attributes:
        texture: name of a texture in `_TEXTURES`, None for plain colour.
        cube: the texture is put on each face whole, instead of tiled over the surface in metres (along local x and y,
            so that it runs down the sides of a box as stripes).
        repeats_per_m: tiles per metre along local x and y (not for `cube`).
    """

    texture: str | None = None
    cube: bool = False
    repeats_per_m: tuple[float, float] = (1.0, 1.0)
    specular: float = 0.1
    shininess: float = 0.2
    emission: float = 0.0


MATERIALS: dict[str, Material] = {
    "matte": Material(),
    "gloss": Material(specular=0.7, shininess=0.7),
    "metal": Material(specular=0.9, shininess=0.5),
    "glow": Material(emission=0.55, specular=0.0),
    "planks": Material("planks", repeats_per_m=(0.8, 0.8), specular=0.15),
    "tiles": Material("tiles", repeats_per_m=(0.8, 0.8), specular=0.25),
    "plush": Material("fabric", repeats_per_m=(1.5, 1.5), specular=0.0),
    "wood": Material("wood", cube=True, specular=0.15),
    "fabric": Material("fabric", cube=True, specular=0.0),
    "cardboard": Material("cardboard", cube=True, specular=0.0),
    "wicker": Material("wicker", cube=True, specular=0.05),
    "books": Material("books", repeats_per_m=(1.4, 1.4), specular=0.1),
    "rug": Material("rug", cube=True, specular=0.0),
    "sky": Material("sky", cube=True, emission=0.7, specular=0.0),
    "painting": Material("painting", cube=True, specular=0.1),
    "landscape": Material("landscape", cube=True, specular=0.1),
}
"""Material names that a part may carry."""


def add_materials(spec: mujoco.MjSpec, names: Iterable[str]) -> None:
    """Adds the named materials, and the textures that they use, to a model under construction.

    Raises:
        KeyError: a name that is not in `MATERIALS`.
    """
    added: set[str] = set()
    for name in sorted(set(names)):
        material = MATERIALS[name]
        made = spec.add_material(name=name)
        made.specular, made.shininess, made.emission = material.specular, material.shininess, material.emission
        if material.texture is None:
            continue
        texture = f"{material.texture}_{'cube' if material.cube else '2d'}"
        if texture not in added:
            added.add(texture)
            image = texture_image(material.texture)
            kind = mujoco.mjtTexture.mjTEXTURE_CUBE if material.cube else mujoco.mjtTexture.mjTEXTURE_2D
            height, width = image.shape[:2]
            spec.add_texture(
                name=texture, type=kind, width=width, height=height, nchannel=3, data=image.ravel(), gridsize=[1, 1]
            )
        made.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = texture
        if not material.cube:
            made.texuniform = True
            made.texrepeat = list(material.repeats_per_m)


@cache
def texture_image(name: str) -> np.ndarray:
    """(H, W, 3) uint8 of a texture; square. Most are nearly white, to be tinted by the part's colour."""
    image = _TEXTURES[name](np.random.default_rng(sum(map(ord, name))))
    image = (np.clip(image, 0.0, 1.0) * 255.0 + 0.5).astype(np.uint8)
    image.setflags(write=False)
    return image


def _gray(value: np.ndarray) -> np.ndarray:
    return np.repeat(value[..., None], 3, axis=-1)


def _grain(rng: np.random.Generator, n: int) -> np.ndarray:
    """(n, n) wood grain along the second axis, about 1."""
    rows = np.cumsum(rng.normal(0.0, 0.03, n))
    rows = rows - np.linspace(rows[0], rows[-1], n)
    wave = 0.04 * np.sin(np.linspace(0, 2 * np.pi, n))[None, :] * np.sin(np.linspace(0, 8 * np.pi, n))[:, None]
    return 0.92 + 0.4 * rows[:, None] + wave + rng.normal(0.0, 0.015, (n, n))


def _planks(rng: np.random.Generator) -> np.ndarray:
    n, boards = 128, 8
    image = np.zeros((n, n))
    width = n // boards
    for board in range(boards):
        rows = slice(board * width, (board + 1) * width)
        grain = _grain(rng, n)[:width]
        cut = int(rng.integers(0, n))
        image[rows] = grain * rng.uniform(0.86, 1.04)
        image[rows, cut:] *= rng.uniform(0.9, 1.08)
        image[rows, cut : cut + 1] *= 0.6
        image[board * width] *= 0.6
    return _gray(image)


def _tiles(rng: np.random.Generator) -> np.ndarray:
    n, count = 64, 2
    image = 0.95 + rng.normal(0, 0.01, (n, n))
    size = n // count
    for i in range(count):
        for j in range(count):
            image[i * size : (i + 1) * size, j * size : (j + 1) * size] *= rng.uniform(0.94, 1.0)
        image[i * size] = image[:, i * size] = 0.72
    return _gray(image)


def _wood(rng: np.random.Generator) -> np.ndarray:
    return _gray(_grain(rng, 64))


def _fabric(rng: np.random.Generator) -> np.ndarray:
    return _gray(0.93 + rng.normal(0, 0.05, (64, 64)))


def _cardboard(rng: np.random.Generator) -> np.ndarray:
    image = 0.95 + rng.normal(0, 0.015, (64, 64)) + 0.02 * np.sin(np.arange(64) * 1.2)[:, None]
    image[:2] = image[-2:] = image[:, :2] = image[:, -2:] = 0.78
    return _gray(image)


def _wicker(rng: np.random.Generator) -> np.ndarray:
    n, period = 64, 8
    i, j = np.mgrid[:n, :n]
    weave = np.where((i // period + j // period) % 2, np.sin(np.pi * ((i % period) + 0.5) / period),
                     np.sin(np.pi * ((j % period) + 0.5) / period))  # fmt: skip
    return _gray(0.45 + 0.55 * weave + rng.normal(0, 0.02, (n, n)))


def _books(rng: np.random.Generator) -> np.ndarray:
    n = 128
    palette = np.array([[.70, .18, .15], [.16, .33, .55], [.18, .42, .28], [.85, .72, .45], [.35, .2, .4],
                        [.92, .9, .85], [.2, .2, .24], [.8, .45, .2], [.45, .62, .7]])  # fmt: skip
    row = np.zeros((n, 3))
    x, last = 0, -1
    while x < n:
        width = int(rng.integers(3, 9))
        choice = (last + int(rng.integers(1, len(palette)))) % len(palette)
        row[x : x + width] = palette[choice]
        row[x] *= 0.4
        x, last = x + width, choice
    return np.repeat(row[None], n, axis=0)


def _rug(rng: np.random.Generator) -> np.ndarray:
    n = 128
    i, j = np.mgrid[:n, :n]
    edge = np.minimum.reduce([i, j, n - 1 - i, n - 1 - j])
    diamonds = (np.abs((i % 32) - 16) + np.abs((j % 32) - 16)) < 9
    image = np.where(diamonds, 0.62, 0.95)
    image = np.where(edge < 14, np.where((edge > 4) & (edge < 10), 0.95, 0.55), image)
    return _gray(image + rng.normal(0, 0.02, (n, n)))


def _sky(rng: np.random.Generator) -> np.ndarray:
    n = 64
    up = 1.0 - np.arange(n)[:, None, None] / (n - 1)
    image = np.broadcast_to(
        (1 - up) * np.array([0.88, 0.94, 1.0]) + up * np.array([0.45, 0.68, 0.95]), (n, n, 3)
    ).copy()
    column = np.arange(n)
    hills = 44 + 5 * np.sin(column / 9.0) + 3 * np.sin(column / 4.0 + 1)
    image[np.arange(n)[:, None] > hills[None]] = (0.36, 0.55, 0.30)
    image[np.arange(n)[:, None] > hills[None] + 9] = (0.30, 0.46, 0.25)
    return np.rot90(image + rng.normal(0, 0.01, (n, n, 1)))


def _painting(rng: np.random.Generator) -> np.ndarray:
    n = 64
    image = np.full((n, n, 3), (0.93, 0.89, 0.80))
    i, j = np.mgrid[:n, :n]
    for color, (r, c, size) in zip(
        ((0.80, 0.30, 0.20), (0.15, 0.35, 0.50), (0.92, 0.70, 0.25), (0.2, 0.2, 0.22)),
        ((24, 22, 15), (38, 42, 17), (18, 46, 8), (46, 16, 6)),
        strict=True,
    ):
        image[(i - r) ** 2 + (j - c) ** 2 < size**2] = color
    return np.rot90(image + rng.normal(0, 0.01, (n, n, 1)))


def _landscape(rng: np.random.Generator) -> np.ndarray:
    n = 64
    i, j = np.mgrid[:n, :n]
    image = np.full((n, n, 3), (0.95, 0.75, 0.55))
    image[(i - 22) ** 2 + (j - 42) ** 2 < 60] = (1.0, 0.93, 0.75)
    image[i > 26 + np.abs(j - 22) * 0.8] = (0.42, 0.40, 0.55)
    image[i > 34 + np.abs(j - 46) * 0.6] = (0.30, 0.33, 0.48)
    image[i > 48] = (0.25, 0.42, 0.45)
    return np.rot90(image + rng.normal(0, 0.01, (n, n, 1)))


# what hangs on a wall is turned, because the cube map lays images on the +x face on their sides
_TEXTURES: dict[str, Callable[[np.random.Generator], np.ndarray]] = {
    "planks": _planks,
    "tiles": _tiles,
    "wood": _wood,
    "fabric": _fabric,
    "cardboard": _cardboard,
    "wicker": _wicker,
    "books": _books,
    "rug": _rug,
    "sky": _sky,
    "painting": _painting,
    "landscape": _landscape,
}
