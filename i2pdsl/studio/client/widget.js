// Stage, time line and curves in a cell of a notebook (anywidget). i2pdsl/studio/cell.py answers
// the messages of docs/studio-protocol.md; there is no server.
import { Curves } from "./curves.js";
import { Desk } from "./desk.js";
import { fill, h } from "./dom.js";
import { provide } from "./mounted.js";
import { PlainText } from "./plain.js";
import { Stage } from "./stage.js";
import { Timeline } from "./timeline.js";

const SILENT = new Set(["stale", "cancelled"]);
const TOLD = 5000; // milliseconds that something is told

/** Requests over the channel of a widget. */
class Messages {
  #waiting = new Map();
  #heard = new Map();
  #next = 1;
  #own = Math.random().toString(36).slice(2); // two views of one widget hear the same

  constructor(model) {
    this.model = model;
    this.listen = ({ text }) => this.#received(JSON.parse(text));
    model.on("msg:custom", this.listen);
  }

  close() {
    this.model.off("msg:custom", this.listen);
  }

  on(method, listener) {
    this.#heard.set(method, listener);
  }

  request(method, params = {}) {
    const id = `${this.#own}-${this.#next++}`;
    this.#send({ id, method, params });
    return new Promise((resolve, reject) => this.#waiting.set(id, { resolve, reject }));
  }

  notify(method, params) {
    this.#send({ method, params });
  }

  #send(message) {
    this.model.send({ text: JSON.stringify({ jsonrpc: "2.0", ...message }) });
  }

  #received({ id, method, params, result, error }) {
    if (method) return this.#heard.get(method)?.(params);
    const waiting = this.#waiting.get(id);
    this.#waiting.delete(id);
    if (error) waiting?.reject(error);
    else waiting?.resolve(result);
  }
}

class Cell extends Desk {
  plays = false; // several in one notebook shall not move all at once
  #hand = Promise.resolve();

  constructor(root, model) {
    super();
    this.model = model;
    this.rpc = new Messages(model);
    const part = (id) => h("div", { id });
    const [stage, timeline, curves, box] = ["stage", "timeline", "curves", "text"].map(part);
    this.state = h("p", { id: "state", role: "status" });
    const act = (name, click) => h("button", { type: "button", class: "quiet", click }, name);
    this.undo = act("Undo", () => this.text.undo());
    this.redo = act("Redo", () => this.text.redo());
    root.append(
      h(
        "div",
        { class: "desk" },
        h("section", { class: "film" }, stage, timeline),
        h(
          "section",
          { class: "side" },
          h("p", { class: "acts" }, this.undo, this.redo, this.state),
          box,
        ),
        curves,
      ),
    );
    this.text = new PlainText(box, model.get("uri"), model.get("text"), () => this.#changed());
    this.stage = new Stage(stage, this);
    this.timeline = new Timeline(timeline, this);
    this.curves = new Curves(curves, this);
    this.#listen();
    this.#changed();
  }

  #listen() {
    this.follow = () => this.text.take(this.model.get("text"));
    this.model.on("change:text", this.follow);
    this.rpc.on("i2p/story", (told) => {
      if (!this.isPresent(told)) return;
      this.story = told;
      this.stage.refresh();
      this.timeline.refresh();
      this.curves.refresh();
    });
    this.rpc.on("i2p/progress", (told) => {
      if (this.isPresent(told)) this.#say(told.stage === "idle" ? "ready" : `${told.text} …`);
    });
    this.rpc.on("i2p/film", (told) => {
      if (this.isPresent(told)) this.stage.show(told.film);
    });
  }

  #changed() {
    const { text, uri, version } = this.text ?? {};
    if (!text) return;
    this.stage?.textChanged();
    this.undo.disabled = !this.text.canUndo;
    this.redo.disabled = !this.text.canRedo;
    const textDocument = { uri, version };
    this.rpc.notify("textDocument/didChange", { textDocument, contentChanges: [{ text }] });
    if (this.model.get("text") !== text) {
      this.model.set("text", text);
      this.model.save_changes();
    }
    this.solve();
  }

  async solve() {
    const { uri, version } = this.text;
    this.#say("making the film …");
    try {
      await this.rpc.request("i2p/solve", { uri, version });
      if (version === this.text.version) this.#say("ready");
    } catch ({ message, data }) {
      if (SILENT.has(data?.kind) || version !== this.text.version) return;
      this.stage.setStale(true);
      this.#say(message, true);
    }
  }

  #say(text, isWrong = false) {
    this.state.textContent = text;
    this.state.dataset.kind = isWrong ? "wrong" : text === "ready" ? "calm" : "busy";
  }

  tell(text) {
    this.#say(text, true);
    setTimeout(() => this.state.textContent === text && this.#say("ready"), TOLD);
  }

  async request(method, params) {
    try {
      return await this.rpc.request(method, params);
    } catch ({ message, data }) {
      if (!SILENT.has(data?.kind)) this.tell(message);
      return null;
    }
  }

  byHand(method, params) {
    const done = this.#hand.then(async () => {
      const reply = await this.ask(method, params);
      return reply !== null && this.text.apply(reply);
    });
    this.#hand = done.catch(() => {}); // what went wrong once is in nobody's way later
    return done;
  }

  shown(film) {
    this.timeline.setFilm(film);
    this.curves.setFilm(film);
    this.known();
  }

  known() {
    this.stage.setStale(false);
  }

  timeIs(time) {
    this.timeline.show(time);
    this.timeline.setPlaying(this.playback?.isPlaying ?? false);
    this.curves.show(time);
  }

  close() {
    this.playback?.pause();
    this.model.off("change:text", this.follow);
    this.rpc.close();
  }
}

/** What anywidget calls for each view of the widget. */
export function makeWidget({ makers, page, film, desk }) {
  const sheet = (css) => {
    const made = new CSSStyleSheet();
    made.replaceSync(css);
    return made;
  };
  const modules = Object.entries(makers).map(([name, makeStage]) => [name, { makeStage }]);
  provide(Object.fromEntries(modules), [page, film].map(sheet));
  return {
    render({ model, el }) {
      const host = h("div", { class: "i2p-studio" });
      const root = host.attachShadow({ mode: "open" });
      root.adoptedStyleSheets = [page, desk].map((css) => sheet(css.replaceAll(":root", ":host")));
      fill(el, host);
      const made = new Cell(root, model);
      return () => made.close();
    },
  };
}
