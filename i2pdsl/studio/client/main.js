// The studio's page: its parts, and what they say to each other and to the server.
// docs/studio-protocol.md tells of the messages.
import { Candidates } from "./candidates.js";
import { Curves } from "./curves.js";
import { Desk } from "./desk.js";
import { $, clamp, figure, follow, h, later } from "./dom.js";
import { Files } from "./files.js";
import { Out } from "./out.js";
import { keepPicture } from "./picture.js";
import { Palette } from "./palette.js";
import { Connection } from "./rpc.js";
import { Stage } from "./stage.js";
import { Text } from "./text.js";
import { Timeline } from "./timeline.js";
import { Why, Wishes } from "./wishes.js";
import { World } from "./world.js";

const PAUSE = 250; // milliseconds without a key before a film is looked for
const SILENT = new Set(["stale", "cancelled", "lost"]); // what nobody need hear of

class Studio extends Desk {
  folder = "";
  formats = [];
  plays = !matchMedia("(prefers-reduced-motion: reduce)").matches;
  #chosen = null; // the version whose film was chosen by hand
  #progress = "";
  #solved = null; // the version that is solved as well as it will be
  #shown = null; // the version whose film is on the stage
  #wrong = false;
  #calm = ""; // what is said of a world

  constructor() {
    super();
    const token = location.hash.slice(1);
    this.rpc = new Connection(
      token,
      () => this.#connected(),
      () => this.#lost(),
    );
    this.solveSoon = later(() => this.solve(), PAUSE);
    this.text = new Text($("text"), this.rpc, ({ isHand }) => this.#changed(isHand));
    this.stage = new Stage($("stage"), this);
    this.timeline = new Timeline($("timeline"), this);
    this.curves = new Curves($("curves"), this);
    this.panels = {
      others: new Candidates($("others"), this),
      wishes: new Wishes($("wishes"), this),
      why: new Why($("why"), this),
      patterns: new Palette($("patterns"), this),
    };
    this.world = new World($("world"), this);
    this.files = new Files(this);
    this.out = new Out(this);
    this.#listen();
  }

  // ------------------------------------------------------------------ asking the server

  /** A request; null where it was refused, which is told unless it is `quiet` or of no interest. */
  async request(method, params = {}, quiet = false) {
    try {
      return await this.rpc.request(method, params);
    } catch (refused) {
      if (!quiet && !SILENT.has(refused.kind)) this.tell(refused.message);
      return null;
    }
  }

  /** Something was done by hand: the server says which edits of the text it comes to. One after the
   * other, each about the text that the one before left. */
  byHand(method, params) {
    const done = this.#hand.then(() => this.#byHand(method, params));
    this.#hand = done;
    return done;
  }

  #hand = Promise.resolve();

  async #byHand(method, params) {
    const tries = params.range ? 1 : 3; // a range is one of this version alone
    for (let count = 0; count < tries; count += 1) {
      this.text.flush();
      const { uri, version } = this.text;
      if (!this.text.isTold) {
        this.tell("The studio’s server is away: try again in a moment.");
        return false;
      }
      try {
        const reply = await this.rpc.request(method, { uri, version, ...params });
        if (this.text.apply(reply)) return true;
      } catch (refused) {
        if (refused.kind !== "stale") {
          this.tell(refused.message);
          return false;
        }
      }
    }
    this.tell("The text has changed meanwhile: try again.");
    return false;
  }

  async #connected() {
    this.#ready = null;
    const told = await this.request("i2p/studio");
    if (!told) return;
    this.folder = told.folder;
    this.formats = told.formats;
    this.notice(null, "lost");
    if (this.files.path !== null) {
      await this.ready();
      this.text.announce();
      await this.files.again();
      this.#tellState();
      return;
    }
    const path = history.state?.path ?? sessionStorage.getItem("i2p-open") ?? told.start;
    if (
      !(path && (await this.files.open(path))) &&
      !(told.start && (await this.files.open(told.start)))
    ) {
      await this.files.gallery();
    }
    this.ready();
  }

  #ready = null;

  /** Resolves when the language server is there. It takes a moment to come: what needs it not, such
   * as the text itself, is asked for before. */
  ready = () => (this.#ready ??= this.#initialized());

  async #initialized() {
    await this.request("initialize", {
      processId: null,
      rootUri: null,
      capabilities: {
        general: { positionEncodings: ["utf-16"] },
        textDocument: {
          completion: {
            completionItem: { snippetSupport: true, documentationFormat: ["markdown"] },
          },
          hover: { contentFormat: ["markdown"] },
          publishDiagnostics: { versionSupport: true },
        },
      },
    });
    this.rpc.notify("initialized");
  }

  #lost() {
    this.#progress = "";
    if (this.text === undefined) return;
    this.text.lost();
    this.notice(
      "The studio’s server is away. What you type is kept here; it is looked for again.",
      "lost",
    );
    this.#tellState();
  }

  // ------------------------------------------------------------------ text and film

  #changed(isHand) {
    this.files?.keepSoon();
    this.stage?.textChanged();
    $("desk").dataset.text = this.text.version;
    this.dirty();
    if (isHand) {
      this.solveSoon.cancel();
      this.solve();
    } else this.solveSoon();
  }

  async solve() {
    const { uri, version } = this.text;
    if (!this.text.isTold) return; // it is asked for once the server hears of the text
    this.#progress = "making the film …";
    this.#solved = null;
    this.#tellState();
    try {
      await this.rpc.request("i2p/solve", { uri, version, seed: 0, effort: 1 });
    } catch (refused) {
      if (SILENT.has(refused.kind) || version !== this.text.version) return;
      this.#wrong = refused.kind === "story";
      this.stage.setStale(true);
      this.said = refused.message;
    }
    if (version !== this.text.version) return;
    this.#solved = version;
    this.#progress = "";
    this.#tellState();
  }

  #listen() {
    const { rpc } = this;
    rpc.on("i2p/story", (told) => {
      if (!this.isPresent(told)) return;
      this.story = told;
      this.#wrong = false;
      const written = told.numbers.filter(({ value }) => value !== null);
      this.text.setNumbers(told.version, written);
      this.stage.refresh();
      this.timeline.refresh();
      this.curves.refresh();
      this.panels.others.refresh();
    });
    rpc.on("i2p/progress", (told) => {
      // What is looked for besides, such as other films, tells of itself.
      if (!this.isPresent(told) || told.version === this.#solved) return;
      const share = told.total > 1 ? ` ${told.done} of ${told.total}` : "";
      this.#progress = told.stage === "idle" ? "" : `${told.text || told.stage}${share} …`;
      this.#tellState();
    });
    rpc.on("i2p/film", (told) => {
      if (!this.isPresent(told) || this.#chosen === told.version) return;
      this.stage.show({ ...told.film, version: told.version });
    });
    this.text.onDiagnostics = (found) => {
      const mistake = found.find(({ severity }) => severity === "error");
      this.#wrong = mistake !== undefined;
      this.said = mistake?.message.split("\n")[0] ?? "";
      this.#tellState();
    };
    this.#hands();
  }

  /** A film was put on the stage. */
  shown(film) {
    this.timeline.setFilm(film);
    this.curves.setFilm(film);
    this.known();
  }

  /** More is known of the film on the stage. */
  known() {
    if (this.film.version !== undefined) {
      this.#shown = this.film.version;
      $("desk").dataset.film = this.film.version;
    }
    this.stage.setStale(false);
    if (this.film.quality !== "preview" && this.files.path !== null) {
      keepPicture(this.files.place(this.files.path), this.playback.svg);
    }
    for (const panel of Object.values(this.panels)) panel.update?.();
    $("desk").classList.add("has-film");
    this.#tellState();
  }

  /** The stage shows another moment. */
  timeIs(time) {
    this.timeline.show(time);
    this.timeline.setPlaying(this.playback?.isPlaying ?? false);
    this.curves.show(time);
    this.panels.why.showFrame(Math.ceil(time - 1e-9));
  }

  worldShown(told) {
    $("desk").dataset.film = told.version;
    $("desk").classList.add("has-film");
    this.#calm = told.planned ? "planned: stories can be told in it" : "";
    this.#tellState();
  }

  choose(film) {
    this.#chosen = this.text.version;
    this.stage.show(film);
  }

  /** Writes a film's script beside its story. */
  async keep(film) {
    const path = this.files.path.replace(/\.story$/, ".script.json");
    const reply = await this.request("i2p/keep", { film: film.id, path });
    if (reply) this.tell(`Kept as ${reply.path}.`);
  }

  /** Shows a piece of the story in its text. */
  find(source) {
    const wish = this.story?.wishes.find(({ text }) => text === source);
    if (wish) this.text.reveal(wish.range);
    else {
      const at = this.text.text.indexOf(source);
      if (at < 0) return;
      this.text.revealAt(at, at + source.length);
    }
    this.view("text", true);
    this.text.focus();
  }

  opened(path, language) {
    this.story = null;
    $("desk").dataset.language = language;
    this.world.clear();
    this.#calm = "";
    this.stage.clear();
    this.timeline.setFilm(null);
    this.curves.setFilm(null);
    this.panels.others.clear();
    this.panels.patterns.clear();
    $("desk").classList.remove("has-film");
    delete $("desk").dataset.film;
    const name = path
      .split("/")
      .pop()
      .replace(/\.\w+$/, "")
      .replaceAll("-", " ");
    $("title").textContent = name;
    $("title").dataset.of = path;
    document.title = `${name} · i2p studio`;
  }

  // ------------------------------------------------------------------ what is told

  /** Whether there is a film of the present text, and not only a first one. */
  get #isKnown() {
    return this.#shown === this.text.version && this.film?.quality !== "preview";
  }

  dirty() {
    const isDirty = this.files?.isDirty ?? false;
    $("save").disabled = !isDirty;
    $("save").textContent = isDirty ? "Save" : "Saved";
    $("undo").disabled = !this.text.canUndo;
    $("redo").disabled = !this.text.canRedo;
  }

  #tellState() {
    const { film } = this;
    const parts = [];
    if (!this.rpc.isOpen) parts.push("away");
    else if (this.#wrong) parts.push(this.said || "the text has a mistake");
    else if (this.#isKnown || (film && !this.#progress)) {
      parts.push(film.quality === "preview" ? "a first film" : "ready");
      if (film.unmet?.length) parts.push(`${film.unmet.length} not met`);
      if (this.#progress) parts.push("a better one is looked for …");
    } else if (this.#progress) parts.push(this.#progress);
    else if (this.#calm) parts.push(this.#calm);
    $("state").textContent = $("state").title = parts.join(" · ");
    $("state").dataset.kind =
      !this.rpc.isOpen || this.#wrong
        ? "wrong"
        : this.#progress && !this.#isKnown
          ? "busy"
          : "calm";
    this.stage.empty.textContent =
      this.#progress && !this.#wrong ? "The film is being made …" : "The film comes here.";
    this.stage.setStale(this.#wrong);
    if (film) {
      const panel = film.panel ? ` · panel ${figure(film.panel.mean)}` : "";
      this.stage.mark.textContent = `score ${figure(film.score)}${panel}`;
    }
  }

  /** Says something that goes by. */
  tell(text) {
    const node = h("p", { class: "toast" }, text);
    $("notices").append(node);
    setTimeout(() => node.remove(), 6000);
  }

  /** Says something that stays until it is answered; null takes it away. */
  notice(text, key, ...acts) {
    document.querySelector(`[data-notice="${key}"]`)?.remove();
    if (text === null) return;
    const node = h(
      "p",
      { class: "notice", "data-notice": key },
      h("span", {}, text),
      acts.map(([label, act]) =>
        h("button", { type: "button", click: () => (node.remove(), act()) }, label),
      ),
    );
    $("notices").prepend(node);
  }

  // ------------------------------------------------------------------ hands on the page

  view(name, only = false) {
    const desk = $("desk");
    if (only && !matchMedia("(max-width: 46rem)").matches) return;
    desk.dataset.view = name;
    for (const tab of document.querySelectorAll("[role=tab]")) {
      const on = tab.dataset.view === name;
      tab.setAttribute("aria-selected", String(on));
      tab.tabIndex = on ? 0 : -1;
    }
    for (const [each, panel] of Object.entries(this.panels)) panel.setShown(each === name);
  }

  #hands() {
    for (const tab of document.querySelectorAll("[role=tab]")) {
      tab.addEventListener("click", () => this.view(tab.dataset.view));
      tab.addEventListener("keydown", (event) => {
        const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
        if (!by) return;
        const all = [...document.querySelectorAll("[role=tab]")];
        const next = all[(all.indexOf(tab) + by + all.length) % all.length];
        this.view(next.dataset.view);
        next.focus();
        event.preventDefault();
        event.stopPropagation();
      });
    }
    this.view("text");
    $("undo").addEventListener("click", () => this.text.undo());
    $("redo").addEventListener("click", () => this.text.redo());
    $("tidy").addEventListener("click", () => this.text.format());
    $("save").addEventListener("click", () => this.files.save());
    $("open-files").addEventListener("click", () => this.files.gallery());
    $("out").addEventListener("click", () => this.out.open());
    this.#grip();
    document.addEventListener("keydown", (event) => this.#key(event));
  }

  #key(event) {
    const command = event.ctrlKey || event.metaKey;
    const writes = event.target.closest("#text, input:not([type=range]), select, textarea, dialog");
    if (command && event.key.toLowerCase() === "s") {
      event.preventDefault();
      this.files.save();
    } else if (command && !writes && ["z", "y"].includes(event.key.toLowerCase())) {
      event.preventDefault();
      if (event.key.toLowerCase() === "y" || event.shiftKey) this.text.redo();
      else this.text.undo();
    } else if (!command && !event.altKey && !writes && !event.defaultPrevented) {
      const pressed = event.target.closest("button, summary, [role=tab]");
      const keys = {
        " ": () => this.timeline.toggle(),
        ArrowLeft: () => this.timeline.step(-1),
        ArrowRight: () => this.timeline.step(1),
        Home: () => this.timeline.seek(0),
        End: () => this.timeline.seek(this.timeline.last),
      };
      if (!keys[event.key] || (event.key === " " && pressed)) return;
      if (event.target.closest("[role=tabpanel]") && event.key !== " ") return;
      event.preventDefault();
      keys[event.key]();
    }
  }

  #grip() {
    const grip = $("grip");
    const set = (share) => {
      const side = clamp(share, 24, 64);
      $("desk").style.setProperty("--side", `${side}%`);
      grip.setAttribute("aria-valuenow", Math.round(side));
      localStorage.setItem("i2p-side", side);
      return side;
    };
    let side = set(Number(localStorage.getItem("i2p-side") ?? 42));
    grip.addEventListener("pointerdown", (event) => {
      const { left, width } = $("desk").getBoundingClientRect();
      follow(
        grip,
        event,
        (next) => (side = set(100 - (100 * (next.clientX - left)) / width)),
        () => {},
      );
    });
    grip.addEventListener("keydown", (event) => {
      const by = { ArrowLeft: 2, ArrowRight: -2 }[event.key];
      if (!by) return;
      event.preventDefault();
      side = set(side + by);
    });
  }
}

new Studio();
