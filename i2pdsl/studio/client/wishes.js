// What was wished for and what was reached of it; and why viewers believe what they do.
import { figure, fill, h, prose } from "./dom.js";

const probability = (p) => (p > 0 && p < 0.0005 ? "< 0.001" : p.toFixed(3));

/** A panel that asks about the film on the stage, but only while it is seen. */
class Asking {
  #asked = null;

  constructor(host, studio, method) {
    Object.assign(this, { host, studio, method });
    this.body = h("div", {}, h("p", { class: "hint" }, "It is told as soon as there is a film."));
    host.append(this.body);
  }

  setShown(shown) {
    this.shown = shown;
    this.update();
  }

  async update() {
    const film = this.studio.film;
    if (!this.shown || !film || film.quality === "preview" || film === this.#asked) return;
    this.#asked = film;
    const reply = await this.studio.ask(this.method, {}, film);
    if (film !== this.studio.film) return;
    if (!reply) this.#asked = null;
    else this.show(reply, film);
  }
}

export class Wishes extends Asking {
  constructor(host, studio) {
    super(host, studio, "i2p/wishes");
  }

  show({ wishes, finished }, film) {
    const frames = (all) =>
      all.length
        ? h(
            "small",
            {},
            `most is missing in frame${all.length > 1 ? "s" : ""} `,
            all.map((frame) =>
              h(
                "button",
                { type: "button", class: "frame", click: () => this.studio.playback?.seek(frame) },
                String(frame),
              ),
            ),
          )
        : null;
    const unmet = new Set(film.unmet ?? []);
    const rows = wishes.map(({ source, reached, possible, frames: hurt }) => {
      const missing = possible === null ? 0 : Math.abs(possible - reached);
      const share =
        possible === null
          ? 1
          : Math.max(0, 1 - missing / Math.max(Math.abs(possible), Math.abs(reached), 1e-12));
      const bar = h("i");
      bar.style.width = `${(100 * share).toFixed(0)}%`;
      const told =
        possible === null
          ? figure(reached, 4)
          : `${figure(reached, 4)} (${figure(possible, 4)} alone)`;
      return h(
        "li",
        { class: unmet.has(source) ? "unmet" : null },
        h(
          "button",
          {
            type: "button",
            class: "code",
            title: "Shows it in the text",
            click: () => this.studio.find(source),
          },
          h("code", {}, source),
        ),
        possible === null
          ? h("span")
          : h(
              "span",
              {
                class: "bar",
                role: "img",
                "aria-label": `${(100 * share).toFixed(0)} % of what is possible`,
              },
              bar,
            ),
        h("b", {}, told),
        frames(hurt),
      );
    });
    for (const text of unmet) {
      if (!wishes.some(({ source }) => source === text)) {
        rows.unshift(
          h("li", { class: "unmet" }, h("code", {}, text), h("span"), h("b", {}, "not met")),
        );
      }
    }
    fill(
      this.body,
      h(
        "p",
        { class: "hint" },
        finished === false
          ? "What is possible is still being looked for."
          : "How much of each wish the film reaches, of what it could if it were the only one.",
      ),
      h("ul", {}, rows),
    );
  }
}

export class Why extends Asking {
  #items = [];

  constructor(host, studio) {
    super(host, studio, "i2p/why");
  }

  show({ legend, moments }) {
    const item = ({ first, last, name, what, changes }) =>
      h(
        "li",
        { "data-first": first, "data-last": last },
        h(
          "h3",
          {},
          h("button", { type: "button", click: () => this.studio.playback?.seek(last) }, name),
        ),
        h("p", { class: "seen" }, what),
        h(
          "ul",
          {},
          changes.map(({ claim, formal, before, after, because }) =>
            h(
              "li",
              {},
              h("b", {}, `${probability(before)} → ${probability(after)}`),
              h(
                "span",
                {},
                claim,
                formal ? h("small", {}, h("code", {}, formal)) : null,
                (because ?? []).map((reason) => h("small", {}, reason)),
              ),
            ),
          ),
        ),
      );
    this.#items = moments.map(item);
    const moved = ({ changes }) =>
      Math.max(0, ...changes.map(({ before, after }) => Math.abs(after - before)));
    const most = [...moments]
      .sort((a, b) => moved(b) - moved(a))
      .slice(0, 5)
      .filter((one) => moved(one) > 0.05);
    fill(
      this.body,
      h("p", { class: "hint" }, prose((legend ?? []).join("; "))),
      h("ol", { class: "reasons" }, this.#items),
      most.length
        ? h(
            "nav",
            { "aria-label": "What moved viewers most" },
            h("h3", {}, "What moved them most"),
            h(
              "ol",
              { class: "steps" },
              most.map((one) =>
                h(
                  "li",
                  {},
                  h(
                    "button",
                    { type: "button", click: () => this.studio.playback?.seek(one.last) },
                    h("span", {}, one.name),
                    `${one.what}: ${one.changes[0].claim}, ${probability(one.changes[0].before)} → ${probability(one.changes[0].after)}`,
                  ),
                ),
              ),
            ),
          )
        : null,
    );
    this.showFrame(Math.ceil(this.studio.time - 1e-9));
  }

  /** Only what happens in the frame that is shown is told. */
  showFrame(frame) {
    for (const node of this.#items) {
      node.hidden = !(Number(node.dataset.first) <= frame && frame <= Number(node.dataset.last));
    }
  }
}
