// One JSON-RPC socket to the server, that comes back when it is lost.

/** What went wrong with a request: `kind` as in docs/studio-protocol.md, "lost" without a server. */
export class Refused extends Error {
  constructor({ message, data }) {
    super(message);
    this.kind = data?.kind ?? "";
    this.data = data ?? {};
  }
}

const LOST = { message: "the studio's server is not there", data: { kind: "lost" } };

export class Connection {
  #socket = null;
  #waiting = new Map();
  #next = 1;
  #tries = 0;
  #heard = new Map();

  /** `opened` is called after each time that the socket opened, `lost` when it closed. */
  constructor(token, opened, lost) {
    this.token = token;
    this.opened = opened;
    this.lost = lost;
    this.connect();
  }

  get isOpen() {
    return this.#socket?.readyState === WebSocket.OPEN;
  }

  connect() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/socket`, [
      "i2p",
      `i2p.token.${this.token}`,
    ]);
    this.#socket = socket;
    socket.addEventListener("message", (event) => this.#receive(JSON.parse(event.data)));
    socket.addEventListener("open", () => {
      this.#tries = 0;
      this.opened();
    });
    socket.addEventListener("close", () => {
      for (const { reject } of this.#waiting.values()) reject(new Refused(LOST));
      this.#waiting.clear();
      this.lost();
      this.#tries += 1;
      setTimeout(() => this.connect(), Math.min(250 * 2 ** this.#tries, 4000));
    });
  }

  on(method, listener) {
    this.#heard.set(method, listener);
  }

  request(method, params = {}) {
    if (!this.isOpen) return Promise.reject(new Refused(LOST));
    const id = this.#next++;
    this.#send({ id, method, params });
    return new Promise((resolve, reject) => this.#waiting.set(id, { resolve, reject }));
  }

  notify(method, params = {}) {
    if (this.isOpen) this.#send({ method, params });
  }

  #send(message) {
    this.#socket.send(JSON.stringify({ jsonrpc: "2.0", ...message }));
  }

  #receive(message) {
    if (message.method !== undefined) {
      this.#heard.get(message.method)?.(message.params ?? {});
      // What the language server asks of editors, such as to register something, is granted.
      if (message.id !== undefined) this.#send({ id: message.id, result: null });
      return;
    }
    const waiting = this.#waiting.get(message.id);
    if (waiting === undefined) return;
    this.#waiting.delete(message.id);
    if (message.error) waiting.reject(new Refused(message.error));
    else waiting.resolve(message.result);
  }
}
