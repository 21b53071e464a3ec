// The folder: a gallery of its stories, new ones, saving, and what to do when a file is another by
// now. What is typed and not saved is kept in the browser, and offered again.
import { $, fill, h, later, s } from "./dom.js";
import { pictureOf } from "./picture.js";

const KEPT = "i2p-typed:";

// A world to begin with: two rooms, somebody who wants something, somebody who minds.
const WORLD = `# A world of my own.

map
    ...#...
    .A.....
    ...#.B.
    ...#...

tile apple
    symbol = A
    color = "#d9684a"
tile nest
    symbol = B
    color = "#8f7bc2"

character mouse
    success = 0.8
    goals = {apple, nest}
    sprite = "mouse"
    color = "#9aa3ad"
character cat
    goals = {apple, nest, none}
    pushes = {mouse}
    toward = mouse
    attitude = {-2, 0, 2}
    sprite = "cat"
    color = "#c98d5e"

planning
    order = [mouse, cat]
`;

/** Stands where a story has no picture yet. */
const arc = () =>
  s(
    "svg",
    { viewBox: "0 0 48 24", width: 72, "aria-hidden": "true" },
    s("path", { d: "M4 20c9 0 10-16 20-16s11 12 20 12" }),
  );

export class Files {
  #digest = null; // of the open file as it was read or saved; null: not yet there
  #saved = ""; // its text
  #form = null; // of a new story: what is typed into it stays when the list is told anew
  #isOffered = false; // what was typed before waits for an answer
  path = null;
  beginnings = { beginnings: [], worlds: [] };

  constructor(studio) {
    this.studio = studio;
    this.dialog = $("files");
    this.keepSoon = later(() => this.#keep(), 150);
    studio.rpc.on("i2p/changed", (told) => this.#changed(told));
    this.dialog.addEventListener("pointerdown", () => (this.#isPressed = true));
    // A click comes after the pointer is let go.
    const released = later(() => this.#released(), 0);
    for (const end of ["pointerup", "pointercancel"]) addEventListener(end, released);
    addEventListener("pagehide", () => this.#keep());
    addEventListener("beforeunload", (event) => {
      this.#keep();
      if (this.isDirty) event.preventDefault();
    });
  }

  get isDirty() {
    return this.path !== null && this.studio.text.text !== this.#saved;
  }

  // ------------------------------------------------------------------ open and save

  async open(path) {
    if (this.path !== null) this.#keep();
    const found = await this.studio.request("i2p/open", { path });
    if (!found) return false;
    const kept = this.#kept(path);
    this.#isOffered = kept !== null && kept.text !== found.text;
    await this.#opened(found);
    if (this.#isOffered) this.#offer(kept);
    return true;
  }

  async #opened({ path, uri, text, digest, language }) {
    Object.assign(this, { path });
    this.#digest = digest;
    this.#saved = text;
    history.replaceState({ path }, "", location.hash);
    sessionStorage.setItem("i2p-open", path);
    this.dialog.close();
    this.studio.opened(path, language);
    await this.studio.text.open(uri, language, text, this.studio.ready);
    this.studio.dirty();
  }

  /** Saves; `over` also where the file is another by now. True if it was. */
  async save(over = false) {
    if (this.path === null) return false;
    const [path, text] = [this.path, this.studio.text.text];
    let digest = this.#digest;
    try {
      if (over) digest = over;
      const reply = await this.studio.rpc.request("i2p/save", { path, text, digest });
      if (this.path !== path) return true;
      this.#digest = reply.digest;
      this.#saved = text;
      this.studio.rpc.notify("textDocument/didSave", {
        textDocument: { uri: this.studio.text.uri },
      });
      if (!this.isDirty) localStorage.removeItem(KEPT + this.place(path));
      this.studio.dirty();
      this.studio.notice(null, "file");
      return true;
    } catch (refused) {
      if (refused.kind === "conflict") this.#both(refused.data);
      else if (refused.kind === "lost")
        this.studio.tell("Not saved: the server is away. It is kept in this browser.");
      else this.studio.tell(`Not saved: ${refused.message}`);
      return false;
    }
  }

  /** After a lost connection: what the file is by now. */
  async again() {
    if (this.path === null) return;
    const found = await this.studio.request("i2p/open", { path: this.path }, true);
    if (found) this.#changed(found);
  }

  // ------------------------------------------------------------------ what is typed

  #keep() {
    this.keepSoon.cancel();
    if (this.path === null) return;
    if (!this.isDirty) {
      if (!this.#isOffered) localStorage.removeItem(KEPT + this.place(this.path));
      return;
    }
    const kept = { text: this.studio.text.text, when: Date.now() };
    try {
      localStorage.setItem(KEPT + this.place(this.path), JSON.stringify(kept));
    } catch {
      this.studio.tell("This browser has no room to keep what you type: save soon.");
    }
  }

  place = (path) => `${this.studio.folder}/${path}`;

  #kept(path) {
    try {
      return JSON.parse(localStorage.getItem(KEPT + this.place(path)));
    } catch {
      return null;
    }
  }

  #offer({ text, when }) {
    const told = new Date(when).toLocaleString([], { dateStyle: "medium", timeStyle: "short" });
    const answer = (act) => () => {
      this.#isOffered = false;
      act();
      this.#keep();
    };
    const back = ["Bring it back", answer(() => this.studio.text.replace(text))];
    const forget = ["Forget it", answer(() => {})];
    const now = this.studio.text.text;
    this.studio.notice(
      `You typed something here (${told}) that was not saved.`,
      "typed",
      back,
      [
        "Compare",
        () => this.#compare("As it was typed", text, "As the file is", now, back, forget),
      ],
      forget,
    );
  }

  // ------------------------------------------------------------------ somebody else

  async #changed({ path, digest }) {
    if (this.dialog.open) this.#list();
    if (path !== this.path || digest === this.#digest) return;
    if (digest === null) {
      this.#digest = null;
      this.#saved = "";
      this.studio.dirty();
      this.studio.notice("The file was removed by somebody else. Saving writes it again.", "file");
      return;
    }
    const found = await this.studio.request("i2p/open", { path }, true);
    if (!found || path !== this.path || found.digest === this.#digest) return;
    if (!this.isDirty || found.text === this.studio.text.text) {
      this.#digest = found.digest;
      this.#saved = found.text;
      this.studio.text.replace(found.text);
      this.studio.dirty();
      return;
    }
    this.studio.notice("The file was changed outside, and you have changes of your own.", "file", [
      "Show both",
      () => this.#both(found),
    ]);
  }

  /** Both texts, to choose from. */
  #both({ text, digest }) {
    const theirs = () => {
      this.#digest = digest;
      this.#saved = text;
      this.studio.text.replace(text); // one step: undo brings one's own back
      this.studio.dirty();
    };
    this.studio.notice(null, "file");
    this.#compare(
      "Yours",
      this.studio.text.text,
      "As the file is now",
      text,
      ["Keep mine", () => this.save(digest)],
      ["Take the file’s", theirs],
    );
  }

  #compare(left, mine, right, other, ...acts) {
    const dialog = $("both");
    const there = new Set(other.split("\n"));
    const here = new Set(mine.split("\n"));
    const shown = (text, known) =>
      h(
        "pre",
        { tabindex: 0 },
        text
          .split("\n")
          .map((line) => h("span", { class: known.has(line) ? null : "own" }, `${line}\n`)),
      );
    fill(
      dialog,
      h("h2", { id: "both-heading" }, "Two texts of one file"),
      h(
        "div",
        { class: "two" },
        h("div", {}, h("h3", {}, left), shown(mine, there)),
        h("div", {}, h("h3", {}, right), shown(other, here)),
      ),
      h(
        "p",
        { class: "acts" },
        acts.map(([label, act]) =>
          h("button", { type: "button", click: () => (dialog.close(), act()) }, label),
        ),
        h(
          "button",
          { type: "button", class: "quiet", click: () => dialog.close() },
          "Neither, yet",
        ),
      ),
    );
    dialog.showModal();
  }

  // ------------------------------------------------------------------ the gallery

  async gallery() {
    fill(this.dialog, h("h2", { id: "files-heading" }, "Stories"), h("p", {}, "…"));
    if (!this.dialog.open) this.dialog.showModal();
    this.#form = null;
    this.#listed = "";
    const told = this.studio.request("i2p/beginnings");
    await this.#list();
    this.beginnings = (await told) ?? this.beginnings;
    this.#form = this.#new();
    await this.#list();
  }

  #isPressed = false; // somebody presses something in the dialog
  #isLate = false; // the folder is another since
  #listed = ""; // what the dialog shows

  #released() {
    this.#isPressed = false;
    if (!this.#isLate) return;
    this.#isLate = false;
    if (this.dialog.open) this.#list();
  }

  /** Shows the folder. What is pressed stays where it is until it is let go: a button that another
   * took the place of meanwhile would not be clicked. */
  async #list() {
    const { files = [] } = (await this.studio.request("i2p/files")) ?? {};
    const cards = files.map(({ path, about }) => [path, about, this.#kept(path) !== null]);
    const listed = JSON.stringify([this.path, this.#form !== null, cards]);
    if (listed === this.#listed) return;
    if (this.#isPressed) {
      this.#isLate = true;
      return;
    }
    this.#listed = listed;
    const stories = files.filter(({ kind }) => kind === "story");
    const worlds = files.filter(({ kind }) => kind === "world");
    const focused = document.activeElement;
    fill(
      this.dialog,
      h(
        "div",
        { class: "dialog-head" },
        h("h2", { id: "files-heading" }, this.studio.folder || "Stories"),
        this.path !== null
          ? h(
              "button",
              { type: "button", class: "quiet", click: () => this.dialog.close() },
              "Close",
            )
          : null,
      ),
      this.#form,
      stories.length
        ? h(
            "ul",
            { class: "gallery" },
            stories.map((file) => this.#card(file)),
          )
        : h("p", { class: "hint" }, "There is no story in this folder yet: begin one above."),
      worlds.length ? h("h3", {}, "Worlds") : null,
      worlds.length
        ? h(
            "ul",
            { class: "gallery worlds" },
            worlds.map((file) => this.#card(file)),
          )
        : null,
    );
    if (this.#form?.contains(focused)) focused.focus();
    else if (focused?.dataset?.path) {
      this.dialog.querySelector(`[data-path="${CSS.escape(focused.dataset.path)}"]`)?.focus();
    }
  }

  #card({ path, about }) {
    const name = path
      .split("/")
      .pop()
      .replace(/\.\w+$/, "")
      .replaceAll("-", " ");
    const folder = path.includes("/") ? path.slice(0, path.lastIndexOf("/")) : "";
    const typed = this.#kept(path) !== null;
    const picture = pictureOf(this.place(path));
    return h(
      "li",
      {},
      h(
        "button",
        {
          type: "button",
          class: path === this.path ? "file open" : "file",
          "data-path": path,
          click: () => this.open(path),
        },
        picture ? h("img", { src: picture, alt: "" }) : h("i", { class: "no-picture" }, arc()),
        folder ? h("small", {}, folder) : null,
        h("strong", {}, name),
        h("span", { class: "about" }, about ?? ""),
        typed ? h("em", {}, "not saved") : null,
      ),
    );
  }

  #new() {
    const { beginnings, worlds } = this.beginnings;
    const name = h("input", {
      name: "name",
      required: true,
      placeholder: "my-story",
      pattern: "[^\\/\\\\]+",
      "aria-label": "Name",
      autocomplete: "off",
    });
    const world = h(
      "select",
      { "aria-label": "World" },
      worlds.map(({ name: value, about }) => h("option", { value, title: about }, value)),
    );
    const kind = h(
      "select",
      { "aria-label": "Beginning" },
      beginnings.map(({ name: value, about }) =>
        h(
          "option",
          { value, title: about },
          about && about.length < 60 ? `${value}: ${about}` : value,
        ),
      ),
    );
    if (worlds.some(({ name: each }) => each === "kitchen")) world.value = "kitchen";
    const start = async (path, text) => {
      try {
        await this.studio.rpc.request("i2p/save", { path, text, digest: null });
        await this.open(path);
      } catch (refused) {
        const isThere = refused.kind === "conflict";
        this.studio.tell(isThere ? `There is a ${path} already.` : refused.message);
      }
    };
    const begin = async (event) => {
      event.preventDefault();
      const found = await this.studio.request("i2p/new", {
        name: name.value.trim(),
        world: world.value,
        beginning: kind.value || null,
      });
      if (found) await start(found.path, found.text);
    };
    return h(
      "form",
      { class: "new", submit: begin },
      h("strong", {}, "A new story"),
      h("label", {}, h("span", {}, "called"), name),
      h("label", {}, h("span", {}, "in"), world),
      h("label", {}, h("span", {}, "about"), kind),
      h("button", { type: "submit", class: "main-button" }, "Begin"),
      h(
        "button",
        {
          type: "button",
          class: "quiet",
          title: "Begins a map of your own, to be painted",
          click: () => name.reportValidity() && start(`${name.value.trim()}.world`, WORLD),
        },
        "or paint a world of that name",
      ),
    );
  }
}
