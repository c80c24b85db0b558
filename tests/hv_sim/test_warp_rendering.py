"""Warp's pictures show what OpenGL's show."""

import cv2
import numpy as np
import pytest
from warp_scenes import DEVICE, living_room, starts

from hv_sim.rendering import CameraRenderer
from hv_sim.scene import FIRST_OBJECT_BODY
from hv_sim.warp_physics import WarpPhysics
from hv_sim.warp_rendering import WarpRenderer


def test_errors_name_what_is_wrong():
    with pytest.raises(ValueError, match="samples: 0 is not valid"):
        WarpRenderer(samples=0)
    physics = WarpPhysics([living_room().model], device=DEVICE)
    with pytest.raises(ValueError, match="camera: 'tail' is not valid; valid: head"):
        WarpRenderer(8, 8).render_batch(physics, camera="tail")


@pytest.mark.slow
def test_both_cameras_see_the_same_objects():
    """World 0 as the task has it, world 1 with its object 1.2 m before the head, in a colour of its own."""
    scene = living_room()
    model = scene.model.__copy__()
    geoms = model.geom_bodyid == FIRST_OBJECT_BODY
    model.geom_rgba[geoms, :3] = (0.0, 1.0, 0.2)
    model.geom_matid[geoms] = -1
    qpos = starts(1)[0], starts(1)[0].copy()
    yaw = 2 * np.arctan2(qpos[1][6], qpos[1][3])
    qpos[1][35:38] = qpos[1][:3] + 1.2 * np.array([np.cos(yaw), np.sin(yaw), 0.08])
    physics = WarpPhysics([scene.model, model], device=DEVICE)
    assert len(physics.groups) == 1, "colours may differ within a batch"
    physics.reset([0, 1], qpos)
    renderer = WarpRenderer(96, 96)
    warp, opengl = renderer.render_batch(physics), CameraRenderer(96, 96).render_batch(physics)
    assert warp.shape == opengl.shape == (2, 96, 96, 3)
    for ours, theirs in zip(warp, opengl, strict=True):
        smooth = [cv2.GaussianBlur(x.astype(np.float32), (0, 0), 2).ravel() for x in (ours, theirs)]
        assert np.corrcoef(*smooth)[0, 1] > 0.93
        assert np.abs(smooth[0] - smooth[1]).mean() < 12, "of 255"

    def green(image):
        r, g, b = image.astype(int).transpose(2, 0, 1)
        return (g > r + 60) & (g > b + 60)

    seen = [green(pictures[1]) for pictures in (warp, opengl)]
    assert min(s.sum() for s in seen) > 60
    assert (seen[0] & seen[1]).sum() > 0.85 * (seen[0] | seen[1]).sum(), "at the same place"
    assert green(warp[0]).sum() < 0.2 * seen[0].sum(), "it is world 1's alone"
    np.testing.assert_array_equal(renderer.render_batch(physics, [1]), warp[1:])
