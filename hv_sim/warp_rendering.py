"""Pictures of every world at once by Warp's own ray caster, for `WarpPhysics`.

They show what `hv_sim.rendering.CameraRenderer` shows, from the same place, but not the same numbers: a dataset or a
policy keeps to one of the two.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hv_sim.rendering import HEAD_CAMERA
from hv_sim.warp_physics import WarpGroup, WarpPhysics, require_warp

_BACKGROUND = (0.97, 0.97, 0.96, 1.0)


@dataclass
class _View:
    """What one camera of the simulations of a batch needs."""

    group: WarpGroup
    context: Any
    image: Any


class WarpRenderer:
    """Renders a camera of every simulation, on the device of their physics.

    Args:
        height_px: height of the pictures.
        width_px: width of the pictures.
        samples: per pixel along each side, to smooth edges.

    Raises:
        ValueError: a size is not positive, or Warp is not installed.
    """

    def __init__(self, height_px: int = 128, width_px: int = 128, *, samples: int = 2) -> None:
        for name, value in (("height_px", height_px), ("width_px", width_px), ("samples", samples)):
            if value < 1:
                raise ValueError(f"{name}: {value} is not valid; valid: an integer >= 1")
        self._wp, self._mjw = require_warp()
        self.height_px, self.width_px, self._samples = height_px, width_px, samples
        # made when a picture is first asked for; of one physics and camera at a time
        self._of: tuple[WarpPhysics, str] | None = None
        self._views: list[_View] = []

    def render_batch(
        self, physics: WarpPhysics, ids: Sequence[int] | None = None, camera: str = HEAD_CAMERA
    ) -> np.ndarray:
        """Pictures of simulations `ids` (default: all) as they are now, (n, height, width, 3) uint8.

        Raises:
            ValueError: the scenes have no such camera.
        """
        everything = np.empty((physics.num_envs, self.height_px, self.width_px, 3), dtype=np.uint8)
        with self._wp.ScopedDevice(physics.device):
            if self._of is None or self._of[0] is not physics or self._of[1] != camera:
                self._views = [self._view(group, camera) for group in physics.groups]
                self._of = (physics, camera)
            for view in self._views:
                self._mjw.refit_bvh(view.group.model, view.group.data, view.context)
                self._mjw.render(view.group.model, view.group.data, view.context)
                self._mjw.get_rgb(view.context, 0, view.image)
                everything[view.group.ids] = np.round(255 * np.clip(view.image.numpy(), 0.0, 1.0))
        return everything if ids is None else everything[np.asarray(ids, dtype=np.int64)]

    def close(self) -> None:
        """Frees what was made for pictures; a later picture makes it anew."""
        self._of, self._views = None, []

    def _view(self, group: WarpGroup, camera: str) -> _View:
        model = group.models[0]
        names = [model.camera(i).name for i in range(model.ncam)]
        if camera not in names:
            raise ValueError(f"camera: {camera!r} is not valid; valid: {', '.join(names)}")
        context = self._mjw.create_render_context(
            group.able,
            nworld=len(group.ids),
            cam_res=(self.width_px, self.height_px),
            render_rgb=True,
            render_depth=False,
            render_seg=False,
            cam_active=[camera],
            background_color=_BACKGROUND,
            samples_per_pixel=self._samples,
        )
        image = self._wp.zeros((len(group.ids), self.height_px, self.width_px), dtype=self._wp.vec3)
        return _View(group, context, image)
