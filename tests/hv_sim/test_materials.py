"""Materials: every part names one that exists, and textures do not change from run to run."""

import numpy as np
import pytest

from hv_sim.furniture import FURNITURE_KINDS, build_furniture
from hv_sim.materials import _TEXTURES, MATERIALS, texture_image
from hv_sim.objects import OBJECT_KINDS, build_object
from hv_sim.rooms import FLOORS, ROOM_KINDS, build_room


def test_parts_use_materials_that_exist():
    parts = [p for k in FURNITURE_KINDS for p in build_furniture(k)]
    parts += [p for k in OBJECT_KINDS for p in build_object(k).parts]
    for kind in ROOM_KINDS:
        parts += build_room(kind, (6.0, 5.0))
    used = {p.material for p in parts} | {material for material, _ in FLOORS.values()}
    assert used == set(MATERIALS)
    assert {m.texture for m in MATERIALS.values() if m.texture} == set(_TEXTURES)


@pytest.mark.parametrize("name", sorted(_TEXTURES))
def test_textures_are_square_and_repeatable(name):
    image = texture_image(name)
    assert image.dtype == np.uint8
    assert image.shape[0] == image.shape[1] <= 128
    assert image.std() > 1.0  # it shows something
    texture_image.cache_clear()
    np.testing.assert_array_equal(texture_image(name), image)
