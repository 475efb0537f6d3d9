// The one WebSocket, and why it ended.

export const PROTOCOL = 1;
export const TEXTS = "/web/texts.json";

/** An open line to the station. Handlers: message(object), picture(ArrayBuffer), closed(reason). */
export class Connection {
  constructor(handlers) {
    this.opened = false;
    this.handlers = handlers;
    this.socket = new WebSocket(`ws://${location.host}/ws`);
    this.socket.binaryType = "arraybuffer";
    this.socket.addEventListener("open", () => {
      this.opened = true;
      this.send({ type: "hello", protocol: PROTOCOL });
    });
    this.socket.addEventListener("message", ({ data }) => this.#received(data));
    this.socket.addEventListener("close", async ({ code }) => handlers.closed(await reason(code, this.opened)));
  }

  send(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  #received(data) {
    if (typeof data === "string") this.handlers.message(JSON.parse(data));
    else this.handlers.picture(data);
  }
}

/** A key of texts.errors. A browser does not tell why a WebSocket was refused, so the station is asked again. */
export async function reason(code, opened, ask = fetch) {
  if (code === 1008) return "protocol";
  if (code === 1000 || code === 1001) return "stopped";
  try {
    const answer = await ask(TEXTS, { cache: "no-store" });
    if (!answer.ok) return "link";
    return opened ? "lost" : "taken";
  } catch {
    return "lost";
  }
}
