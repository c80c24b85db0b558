// The websocket to hv-live: comes back by itself, hands on messages and pairs of pictures.

const RETRY_MS = [500, 1000, 2000, 4000];

export class Link {
  /** @param handlers {message(data), pictures(thirdPerson: Blob, head: Blob), open(), lost()} */
  constructor(handlers) {
    this.handlers = handlers;
    this.failures = 0;
    this.connect();
  }

  connect() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    this.socket = new WebSocket(`${scheme}//${location.host}/live`);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => { this.failures = 0; this.handlers.open(); };
    this.socket.onmessage = (event) => {
      if (typeof event.data === "string") this.handlers.message(JSON.parse(event.data));
      else this.handlers.pictures(...split(event.data));
    };
    this.socket.onclose = () => {
      this.handlers.lost();
      setTimeout(() => this.connect(), RETRY_MS[Math.min(this.failures++, RETRY_MS.length - 1)]);
    };
  }

  /** Sends {type, ...fields}; says whether the line was open. */
  send(type, fields = {}) {
    if (this.socket.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify({ type, ...fields }));
    return true;
  }
}

function split(buffer) {
  const length = new DataView(buffer).getUint32(0);
  const jpeg = { type: "image/jpeg" };
  return [new Blob([buffer.slice(4, 4 + length)], jpeg), new Blob([buffer.slice(4 + length)], jpeg)];
}
