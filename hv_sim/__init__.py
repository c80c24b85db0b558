"""The world: humanoid, rooms, objects, tasks, physics, cameras and the gymnasium environment `hv_sim/Rearrange-v0`.

Importing this package registers the environment and picks an OpenGL backend; it imports neither MuJoCo nor torch.
"""

from __future__ import annotations

import gymnasium

from hv_sim.gl_backend import select_gl_backend

ENV_ID = "hv_sim/Rearrange-v0"

select_gl_backend()

if ENV_ID not in gymnasium.registry:
    gymnasium.register(id=ENV_ID, entry_point="hv_sim.rearrange_env:RearrangeEnv")
