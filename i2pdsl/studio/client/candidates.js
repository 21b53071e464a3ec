// A wall of other films of the same story, that play side by side; and how one could go on.
import { figure, h } from "./dom.js";
import { filmHost, mountFilm } from "./mounted.js";

const COUNT = 8;
const ORDERS = {
  panel: ["Panel", ({ panel }) => panel?.mean],
  score: ["Score", ({ score }) => score],
  lively: ["Liveliness", ({ lively }) => lively],
  contact: ["Contact", ({ contact }) => contact],
};
export class Candidates {
  #cards = []; // {film, node, playback}
  #seed = 0;
  #number = 0;

  constructor(host, studio) {
    this.studio = studio;
    this.host = host;
    this.find = h(
      "button",
      { type: "button", class: "main-button", click: () => this.search() },
      "Find others",
    );
    this.onward = h(
      "button",
      {
        type: "button",
        title: "Shows how the film could go on after the frame that is shown",
        click: () => this.suggest(),
      },
      "What if, from here",
    );
    this.order = h(
      "select",
      { "aria-label": "Sorted by", change: () => this.#sort() },
      Object.entries(ORDERS).map(([value, [label]]) =>
        h("option", { value }, `by ${label.toLowerCase()}`),
      ),
    );
    this.said = h(
      "p",
      { class: "hint", role: "status" },
      "Other films of this story, to choose from: mirrors and near twins are left out.",
    );
    this.wall = h("ul", { class: "wall" });
    host.append(
      h("div", { class: "panel-head" }, this.find, this.onward, this.order),
      this.said,
      this.wall,
    );
    this.watch = setInterval(() => this.#again(), 400);
  }

  /** The panel is seen, or is no longer. */
  setShown(shown) {
    this.shown = shown;
    if (!shown) for (const { playback } of this.#cards) playback?.pause();
    else if (!this.#cards.length && this.studio.film) this.search();
  }

  /** Another story was opened. */
  clear() {
    this.#number += 1;
    this.#show([]);
    this.onward.disabled = !this.studio.story?.can.suggest;
  }

  refresh() {
    this.onward.disabled = !this.studio.story?.can.suggest;
  }

  async search() {
    const number = ++this.#number;
    this.#wait("Looking for other films …");
    const seed = this.#seed++;
    const reply = await this.studio.ask("i2p/candidates", { seed, count: COUNT });
    if (number !== this.#number) return;
    this.find.disabled = false;
    if (!reply) {
      this.said.textContent = "None were found for the text as it is.";
      return;
    }
    this.#show(reply.candidates.map((film) => ({ film })));
    this.#sort();
    const count = reply.candidates.length;
    this.said.textContent = `${count} film${count === 1 ? "" : "s"}. Press one to put it on the stage.`;
    this.find.textContent = "Find more";
  }

  async suggest() {
    const number = ++this.#number;
    const frame = this.studio.frame;
    this.#wait(`Looking for ways to go on after frame ${frame} …`);
    const reply = await this.studio.ask("i2p/suggest", { frame, frames: 1 }, this.studio.film);
    if (number !== this.#number) return;
    this.find.disabled = false;
    const found = reply?.suggestions ?? [];
    this.#show(found.map(({ film, text, breaks }) => ({ film, text, breaks, frame: frame + 1 })));
    this.said.textContent = found.length
      ? `What could happen in frame ${frame + 1}, the best first.`
      : "Nothing was found that could follow.";
  }

  #wait(text) {
    this.find.disabled = true;
    this.said.textContent = text;
  }

  #show(all) {
    for (const { playback } of this.#cards) playback?.pause();
    this.#cards = all.map((each) => this.#card(each));
    this.wall.replaceChildren(...this.#cards.map(({ node }) => node));
  }

  #card({ film, text, breaks, frame }) {
    const screen = filmHost({ class: "small-screen" });
    const bars = h("p", { class: "figures" });
    if (text) bars.append(text);
    else {
      bars.append(
        ...Object.values(ORDERS)
          .slice(0, 2)
          .map(([label, of]) =>
            h("span", {}, `${label.toLowerCase()} `, h("b", {}, figure(of(film)))),
          ),
      );
    }
    const card = { film, playback: null };
    const go = () =>
      this.studio.byHand("i2p/hold", {
        film: film.id,
        first: 1,
        last: frame ?? Math.max(1, this.studio.frame || Math.ceil(film.play.last / 2)),
      });
    const choose = () => {
      for (const { node } of this.#cards) node.classList.toggle("chosen", node === card.node);
      this.studio.choose(film);
    };
    card.node = h(
      "li",
      {},
      h(
        "button",
        {
          type: "button",
          class: "pick",
          click: choose,
          "aria-label": `Put on the stage: ${text ?? `panel ${figure(film.panel?.mean)}, score ${figure(film.score)}`}`,
        },
        screen,
      ),
      bars,
      breaks?.length ? h("p", { class: "breaks" }, `breaks ${breaks.join("; ")}`) : null,
      h(
        "div",
        { class: "acts" },
        this.studio.story?.can.hold
          ? h(
              "button",
              {
                type: "button",
                class: "quiet",
                click: go,
                title: frame
                  ? "Pins the film up to this frame"
                  : "Pins the beginning as it is here (up to the frame on the stage, or half of it); what comes after is found anew",
              },
              "Go on from it",
            )
          : null,
        h(
          "button",
          {
            type: "button",
            class: "quiet",
            click: () => this.studio.keep(film),
            title: "Writes its script beside the story",
          },
          "Keep",
        ),
      ),
    );
    mountFilm(screen, film.play).then((playback) => {
      card.playback = playback;
      playback?.setSpeed(2);
      if (frame) playback?.seek(frame - 1);
    });
    return card;
  }

  #sort() {
    const [, of] = ORDERS[this.order.value];
    this.#cards.sort((a, b) => (of(b.film) ?? -Infinity) - (of(a.film) ?? -Infinity));
    this.wall.append(...this.#cards.map(({ node }) => node));
  }

  /** All play together, from the start once the longest has ended. */
  #again() {
    if (!this.shown || !this.studio.plays || !this.#cards.length || document.hidden) return;
    const all = this.#cards.map(({ playback }) => playback).filter(Boolean);
    if (all.length && all.every(({ isPlaying }) => !isPlaying)) {
      for (const each of all) {
        each.seek(0);
        each.play();
      }
    }
  }
}
