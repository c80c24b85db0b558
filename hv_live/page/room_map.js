// The room from above, in SVG: what stands there once, what moves at every state.

const NS = "http://www.w3.org/2000/svg";

function shape(name, attributes, parent) {
  const element = document.createElementNS(NS, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  parent.append(element);
  return element;
}

const degrees = (yaw) => (-yaw * 180) / Math.PI;
const place = (element, x, y, yaw = 0) => element.setAttribute("transform", `translate(${x} ${-y}) rotate(${degrees(yaw)})`);

export class RoomMap {
  /** @param svg where to draw; @param pick(label) is told which thing was clicked */
  constructor(svg, pick) {
    this.svg = svg;
    this.pick = pick;
    this.room = null;
  }

  /** Draws a room anew; positions in metres, y up. */
  draw(room) {
    this.room = room;
    const [w, h] = room.size, edge = 0.12;
    this.svg.replaceChildren();
    this.svg.setAttribute("viewBox", `${-w / 2 - edge} ${-h / 2 - edge} ${w + 2 * edge} ${h + 2 * edge}`);
    shape("rect", { x: -w / 2, y: -h / 2, width: w, height: h, rx: 0.08, class: "floor" }, this.svg);
    for (const piece of [...room.furniture].sort((a, b) => b.flat - a.flat)) {
      const group = shape("g", { class: piece.flat ? "rug" : "piece" }, this.svg);
      place(group, piece.x, piece.y, piece.yaw);
      shape("rect", { x: -piece.depth / 2, y: -piece.width / 2, width: piece.depth, height: piece.width, rx: 0.05 }, group);
      shape("title", {}, group).textContent = piece.label;
      if (!piece.flat && Math.max(piece.depth, piece.width) > 0.7) {
        const upright = shape("text", { class: "label" }, this.svg);
        upright.textContent = piece.label;
        const across = Math.abs(Math.sin(piece.yaw)) > 0.7;
        const wide = across ? piece.width : piece.depth, high = across ? piece.depth : piece.width;
        const turned = wide < 0.11 * piece.label.length && high > wide;
        const size = Math.min(0.2, Math.max(0.12, (turned ? high : wide) / (0.58 * piece.label.length)));
        upright.setAttribute("font-size", size.toFixed(3));
        upright.setAttribute("transform", `translate(${piece.x} ${-piece.y})${turned ? " rotate(-90)" : ""}`);
      }
    }
    this.way = shape("path", { class: "way" }, this.svg);
    this.goal = shape("g", { class: "goal" }, this.svg);
    shape("circle", { r: 0.2 }, this.goal);
    shape("path", { d: "M-.09 0H.09M0-.09V.09" }, this.goal);
    this.things = room.objects.map((thing) => {
      const [x, y] = thing.half;
      const group = shape("g", { class: "thing", tabindex: -1 }, this.svg);
      shape("rect", { x: -x, y: -y, width: 2 * x, height: 2 * y, rx: 0.04, fill: thing.color }, group);
      shape("title", {}, group).textContent = thing.label;
      group.addEventListener("click", () => this.pick(thing.label));
      return group;
    });
    this.robot = shape("g", { class: "robot" }, this.svg);
    shape("path", { d: "M.12-.3 .42 0 .12 .3z", class: "gaze" }, this.robot);
    shape("circle", { r: 0.22 }, this.robot);
  }

  /** Moves what moves. */
  show(state) {
    if (!this.room || state.objects.length !== this.things.length) return;
    place(this.robot, ...state.robot);
    state.objects.forEach((at, k) => {
      place(this.things[k], ...at);
      this.things[k].classList.toggle("wanted", state.goal?.object === k);
    });
    this.goal.style.display = this.way.style.display = state.goal ? "" : "none";
    if (!state.goal) return;
    const [x, y] = state.objects[state.goal.object];
    place(this.goal, state.goal.x, state.goal.y);
    this.way.setAttribute("d", `M${x} ${-y}L${state.goal.x} ${-state.goal.y}`);
  }
}
