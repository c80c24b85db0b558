"""One HTML page with two pictures, a map and the instructions of every task, to be filtered by room and object."""

from __future__ import annotations

import html
import json
from pathlib import Path

import mujoco
import numpy as np
from PIL import Image
from tqdm import tqdm

from hv_sim.furniture import FURNITURE_KINDS
from hv_sim.objects import OBJECT_KINDS
from hv_sim.parts import COLORS
from hv_sim.places import layout_at
from hv_sim.rendering import CameraRenderer
from hv_sim.scene import compile_scene
from hv_sim.task import Task

_PIXELS_PER_M = 30
_ARROWS = ("#d1342f", "#1f6fb2", "#2d8a46", "#b0681d", "#7a3fa0")


def write_gallery(tasks: list[Task], folder: Path, size_px: int = 256) -> Path:
    """Writes `index.html` and its pictures into a folder; returns the page.

    Args:
        tasks: what is shown.
        folder: is made if it does not exist.
        size_px: width of the pictures; they are 3/4 as high.

    Raises:
        hv_sim.gl_backend.GLError: no OpenGL library can render off screen here.
    """
    pictures = folder / "pictures"
    pictures.mkdir(parents=True, exist_ok=True)
    renderer = CameraRenderer(size_px * 3 // 4, size_px, max_scenes=1)
    cards = []
    try:
        for task in tqdm(tasks, desc="gallery", unit="task"):
            scene = compile_scene(task)
            for view, camera in (("room", overview_camera(task)), ("head", "head")):
                picture = renderer.render_qpos(scene.model, scene.initial_qpos, camera)
                Image.fromarray(picture).save(pictures / f"{task.name}_{view}.jpg", quality=85)
            cards.append(_card(task))
    finally:
        renderer.close()
    rooms = sorted({t.room.kind for t in tasks})
    kinds = sorted({o.kind for t in tasks for o in t.objects})
    page = (
        _PAGE.replace("@ROOMS", _options(rooms)).replace("@KINDS", _options(kinds)).replace("@CARDS", "\n".join(cards))
    )
    draft = folder / ".index.html.tmp"
    draft.write_text(page, encoding="utf-8")
    draft.replace(folder / "index.html")
    return folder / "index.html"


def overview_camera(task: Task) -> mujoco.MjvCamera:
    """A camera outside the room that sees all of it from above the south wall."""
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.lookat[:] = [0.0, -0.05 * task.room.size_m[1], 0.2]
    camera.azimuth, camera.elevation = 90.0, -58.0
    camera.distance = 1.12 * max(task.room.size_m[0], 1.25 * task.room.size_m[1])
    return camera


def _card(task: Task) -> str:
    said = []
    for i, subtask in enumerate(task.subtasks):
        more = "".join(f"<li>{html.escape(p)}</li>" for p in subtask.paraphrases)
        color = _ARROWS[i % len(_ARROWS)]
        said.append(
            f'<details><summary style="border-color:{color}">{html.escape(subtask.instruction)}</summary>'
            f"<ul>{more}</ul></details>"
        )
    kinds = html.escape(json.dumps(sorted({o.kind for o in task.objects})), quote=True)
    name = html.escape(task.name)
    return (
        f'<article data-room="{task.room.kind}" data-kinds="{kinds}"><h2>{name} <small>{task.room.kind}</small></h2>'
        f'<div class="row"><img loading="lazy" src="pictures/{name}_room.jpg" alt="the room of {name}">'
        f'<img loading="lazy" src="pictures/{name}_head.jpg" alt="what the robot sees first">{_map(task)}</div>'
        f"{''.join(said)}</article>"
    )


def _map(task: Task) -> str:
    """The room from above as SVG: furniture, the robot, and an arrow from where each object is to where it goes."""
    x, y = task.room.size_m
    width, height = x * _PIXELS_PER_M, y * _PIXELS_PER_M

    def at(point) -> tuple[float, float]:
        return (point[0] + x / 2) * _PIXELS_PER_M, (y / 2 - point[1]) * _PIXELS_PER_M

    shapes = [f'<rect width="{width:.0f}" height="{height:.0f}" fill="#f4efe6" stroke="#777"/>']
    for piece in task.furniture:
        spec = FURNITURE_KINDS[piece.kind]
        depth, wide, _ = piece.size_m or spec.size_m
        shapes.append(_rectangle(at(piece.position_m), depth, wide, piece.yaw_rad, "#cfc4b2", spec.noun))
    for thing in task.objects:
        kind = OBJECT_KINDS[thing.kind]
        size, color = thing.size_m or kind.size_m, COLORS[thing.color or kind.color]
        fill = f"rgb({','.join(str(round(255 * c)) for c in color)})"
        shapes.append(_rectangle(at(thing.position_m), size[0], size[1], thing.yaw_rad, fill, thing.name))
    for i, subtask in enumerate(task.subtasks):
        (x1, y1), (x2, y2) = at(layout_at(task, i).poses[subtask.object][0]), at(subtask.goal_position_m)
        ink = _ARROWS[i % len(_ARROWS)]
        ends = f'x1="{x1:.0f}" y1="{y1:.0f}" x2="{x2:.0f}" y2="{y2:.0f}"'
        shapes.append(f'<line {ends} stroke="{ink}" stroke-width="2"/>')
        shapes.append(f'<circle cx="{x2:.0f}" cy="{y2:.0f}" r="5" fill="{ink}"/>')
    rx, ry = at(task.robot.position_m)
    turn = f"translate({rx:.0f},{ry:.0f}) rotate({-np.degrees(task.robot.yaw_rad):.0f})"
    shapes.append(f'<path d="M10,0L-6,6L-6,-6Z" fill="#222" transform="{turn}"/>')
    return f'<svg viewBox="-2 -2 {width + 4:.0f} {height + 4:.0f}" role="img">{"".join(shapes)}</svg>'


def _rectangle(at: tuple[float, float], depth: float, wide: float, yaw: float, fill: str, title: str) -> str:
    d, w = depth * _PIXELS_PER_M, wide * _PIXELS_PER_M
    turn = f"translate({at[0]:.1f},{at[1]:.1f}) rotate({-np.degrees(yaw):.1f})"
    box = f'x="{-d / 2:.1f}" y="{-w / 2:.1f}" width="{d:.1f}" height="{w:.1f}"'
    return f'<rect {box} fill="{fill}" stroke="#555" transform="{turn}"><title>{html.escape(title)}</title></rect>'


def _options(values: list[str]) -> str:
    return "".join(f"<option>{html.escape(v)}</option>" for v in values)


_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>Tasks</title>
<style>
body { font: 15px/1.4 system-ui, sans-serif; margin: 0; background: #fafafa; color: #222 }
header { position: sticky; top: 0; background: #fff; border-bottom: 1px solid #ddd; padding: 10px 16px; display: flex;
  flex-wrap: wrap; gap: 8px 14px; z-index: 1 }
main { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 560px), 1fr)); gap: 14px;
  padding: 14px }
article { background: #fff; border: 1px solid #ddd; border-radius: 8px; padding: 10px }
h2 { font-size: 16px; margin: 0 0 6px } small { color: #777; font-weight: normal }
.row { display: grid; grid-template-columns: repeat(3, 1fr); gap: 6px; margin-bottom: 6px; align-items: center }
img, svg { width: 100%; height: auto; border-radius: 4px }
summary { cursor: pointer; border-left: 4px solid; padding-left: 8px; margin: 3px 0 }
ul { margin: 2px 0 6px; color: #555 } select, input { font: inherit; padding: 2px 6px }
</style></head><body>
<header><label>Room <select id="room"><option value="">all</option>@ROOMS</select></label>
<label>Object <select id="kind"><option value="">all</option>@KINDS</select></label>
<label>Says <input id="text" placeholder="countertop"></label><span id="count"></span></header>
<main>@CARDS</main>
<script>
const cards = [...document.querySelectorAll("article")], get = id => document.getElementById(id);
function filter() {
  const room = get("room").value, kind = get("kind").value, text = get("text").value.toLowerCase();
  let shown = 0;
  for (const card of cards) {
    const fits = (!room || card.dataset.room === room) && (!kind || JSON.parse(card.dataset.kinds).includes(kind))
      && (!text || card.textContent.toLowerCase().includes(text));
    card.hidden = !fits; shown += fits;
  }
  get("count").textContent = shown + " of " + cards.length + " tasks";
}
for (const id of ["room", "kind", "text"]) get(id).addEventListener("input", filter);
filter();
</script></body></html>
"""
