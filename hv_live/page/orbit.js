// Turning the third-person camera: drag, wheel, pinch, keys. Angles as in MuJoCo's free camera.

const DEGREES_PER_PIXEL = 0.35, KEY_DEGREES = 6, SEND_EVERY_MS = 60;
const clamp = (value, low, high) => Math.min(high, Math.max(low, value));

export class Orbit {
  /** @param canvas the view; @param send(fields) gives the camera's wish to the server */
  constructor(canvas, send) {
    this.send = send;
    this.wish = null;
    this.shown = null;
    this.enabled = true;
    this.timer = 0;
    this.pointers = new Map();
    canvas.addEventListener("pointerdown", (e) => {
      canvas.setPointerCapture(e.pointerId);
      this.pointers.set(e.pointerId, [e.clientX, e.clientY]);
    });
    canvas.addEventListener("pointermove", (e) => this.moved(e));
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      canvas.addEventListener(end, (e) => this.pointers.delete(e.pointerId));
    }
    canvas.addEventListener("wheel", (e) => { e.preventDefault(); this.turn(0, 0, Math.exp(e.deltaY * 0.001)); }, { passive: false });
    canvas.addEventListener("keydown", (e) => {
      const turns = { ArrowLeft: [-KEY_DEGREES, 0, 1], ArrowRight: [KEY_DEGREES, 0, 1], ArrowUp: [0, KEY_DEGREES, 1],
        ArrowDown: [0, -KEY_DEGREES, 1], "+": [0, 0, 0.9], "=": [0, 0, 0.9], "-": [0, 0, 1.1] };
      if (turns[e.key] && !e.ctrlKey && !e.metaKey) { e.preventDefault(); this.turn(...turns[e.key]); }
    });
  }

  /** What the server's camera is now. */
  follow(camera) {
    this.shown = camera;
    if (!this.timer) this.wish = null;
  }

  /** The camera goes home: what was still to be sent is not. */
  forget() {
    clearTimeout(this.timer);
    this.timer = 0;
    this.wish = null;
  }

  moved(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const now = [event.clientX, event.clientY];
    if (this.pointers.size === 1) {
      this.turn((before[0] - now[0]) * DEGREES_PER_PIXEL, (before[1] - now[1]) * DEGREES_PER_PIXEL, 1);
    } else {
      const [other] = [...this.pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
      const apart = (at) => Math.hypot(at[0] - other[0], at[1] - other[1]);
      this.turn(0, 0, apart(before) / Math.max(1, apart(now)));
    }
    this.pointers.set(event.pointerId, now);
  }

  turn(azimuth, elevation, zoom) {
    const from = this.wish ?? this.shown;
    if (!from || !this.enabled) return;
    this.wish = {
      azimuth_deg: ((from.azimuth_deg + azimuth) % 360),
      elevation_deg: clamp(from.elevation_deg + elevation, -89, 10),
      distance_m: clamp(from.distance_m * zoom, 1.2, 12),
    };
    if (this.timer) return;
    this.send(this.wish);
    this.timer = setTimeout(() => { this.timer = 0; if (this.wish) this.send(this.wish); }, SEND_EVERY_MS);
  }
}
