// The film, and hands on it: somebody who is dragged to another place is pinned there.
import { clamp, focusedBeside, follow, h, s } from "./dom.js";
import { filmHost, mountFilm } from "./mounted.js";

const PIN = "M0 0C-9 -11 -10 -16 -10 -20a10 10 0 0 1 20 0c0 4 -1 9 -10 20z";

/** Whether somebody can be at a spot, as far as is known: where bodies move nobody knows before. */
const isOpen = ({ possible }) => possible !== false;

export class Stage {
  #playback = null;
  #placing = null; // {who, frame, spots, chosen, ghost}: somebody looks for a place
  #pending = null; // a film that came meanwhile
  #layer = null; // of the drawing, below who acts: where somebody can be
  #above = null; // and above all: pins

  constructor(host, studio) {
    this.studio = studio;
    this.film = null;
    this.host = filmHost({ class: "screen" });
    this.badge = h("span", { class: "badge" }, "Start");
    this.caption = h("span", { class: "caption" });
    this.cast = h("div", { class: "cast", role: "group", "aria-label": "Give a place" });
    this.away = h(
      "button",
      { type: "button", class: "chip", hidden: true, click: () => this.#away() },
      "not there",
    );
    this.said = h("p", { class: "unseen", "aria-live": "polite" });
    this.empty = h("p", { class: "empty" }, "The film comes here.");
    this.mark = h("span", { class: "quality" });
    host.append(
      this.empty,
      this.host,
      this.said,
      h(
        "div",
        { class: "under" },
        h("p", { class: "telling" }, this.badge, this.caption),
        this.mark,
      ),
      this.cast,
    );
    this.host.tabIndex = -1;
    this.host.addEventListener("pointerdown", (event) => this.#press(event));
    this.host.addEventListener("pointermove", (event) => this.#hover(event));
    this.host.addEventListener("keydown", (event) => this.#key(event));
  }

  get time() {
    return this.#playback?.time ?? 0;
  }

  get frame() {
    return Math.round(this.time);
  }

  get playback() {
    return this.#playback;
  }

  /** Shows a film; time goes on where it was. */
  async show(film) {
    if (this.#placing) {
      this.#pending = film; // hands come first
      return;
    }
    if (this.film && film.same === this.film.id) {
      this.film = film; // the same once more, known better
      this.studio.known();
      return;
    }
    const before = this.#playback;
    const [time, playing, speed] = [
      this.time,
      before?.isPlaying ?? this.studio.plays,
      before?.speed,
    ];
    const playback = await mountFilm(this.host, film.play, {
      onDraw: (now) => this.#drawn(now),
    });
    if (!playback) return;
    before?.pause();
    this.film = film;
    this.#playback = playback;
    this.empty.hidden = true;
    this.host.style.setProperty("--shape", film.play.aspect);
    this.#layer = s("g", { class: "hands" });
    const above = [...playback.svg.children].find((node) => node.matches("#actors, .trail"));
    playback.svg.insertBefore(this.#layer, above ?? null);
    if (speed) playback.setSpeed(speed);
    playback.seek(Math.min(time, film.play.last));
    if (playing) playback.play();
    this.#above = s("g", { class: "hands" });
    playback.svg.append(this.#above);
    this.#listCast();
    this.#drawPins();
    this.studio.shown(film);
  }

  /** Another story was opened. */
  clear() {
    this.#pending = null;
    this.leave();
    this.#playback?.pause();
    this.host.film = null;
    this.host.shadowRoot.replaceChildren();
    this.#playback = this.film = this.#layer = this.#above = null;
    this.#shownFrame = -1;
    this.empty.hidden = false;
    this.badge.textContent = "Start";
    this.caption.textContent = this.mark.textContent = "";
    this.cast.hidden = true;
    delete this.cast.dataset.names;
  }

  /** Shows whether the film is of the text as it is. */
  setStale(stale) {
    this.host.classList.toggle("stale", stale);
  }

  /** The text has changed: places that are lit were those of the one before. Who is held by the
   * pointer stays in the hand. */
  textChanged() {
    if (!this.#placing?.held) this.leave();
  }

  /** What is known of the story has changed: who can be dragged, who is pinned. */
  refresh() {
    this.#listCast();
    this.#drawPins();
  }

  // ------------------------------------------------------------------ what is drawn

  #drawn(time) {
    if (!this.film) return;
    const frame = Math.ceil(time - 1e-9);
    if (frame !== this.#shownFrame) {
      this.#shownFrame = frame;
      this.badge.textContent = frame === 0 ? "Start" : `Frame ${frame}`;
      this.caption.textContent = this.film.play.captions[frame] ?? "";
      this.#drawPins();
    }
    this.studio.timeIs(time);
  }

  #shownFrame = -1;

  get #size() {
    const { width, height } = this.#playback.svg.viewBox.baseVal;
    return Math.min(width, height);
  }

  #at(member, frame = this.frame) {
    return this.film.cast.find(({ name }) => name === member)?.at[frame] ?? null;
  }

  #drawPins() {
    if (!this.#above || this.#placing) return;
    const scale = this.#size / 420;
    const pins = this.studio.pins.filter(
      ({ frame, last }) => frame <= this.frame && this.frame <= last,
    );
    this.#above.replaceChildren(
      ...pins.flatMap(({ who }) => {
        const at = who && this.#at(who);
        if (!at) return [];
        const place = `translate(${at[0] + 26 * scale} ${at[1] - 22 * scale}) scale(${scale})`;
        return [s("g", { class: "pin", transform: place }, s("path", { d: PIN }))];
      }),
    );
  }

  #listCast() {
    const drag = this.studio.story?.can.drag ?? [];
    this.cast.hidden = !this.film || drag.length === 0;
    if (this.cast.hidden) return;
    const now = drag.join();
    if (this.cast.dataset.names === now) return;
    this.cast.dataset.names = now;
    this.cast.replaceChildren(
      h("span", {}, "Place"),
      ...drag.map((who) =>
        h(
          "button",
          {
            type: "button",
            class: "chip",
            "aria-pressed": "false",
            "data-who": who,
            title: `Choose where ${who} is in this frame`,
            click: () => (this.#placing?.who === who ? this.leave() : this.#begin(who)),
          },
          who,
        ),
      ),
      this.away,
      h(
        "span",
        { class: "how" },
        "or drag somebody on the stage: that pins where they are in this frame.",
      ),
    );
  }

  // ------------------------------------------------------------------ a place for somebody

  #point(event) {
    const matrix = this.#playback.svg.getScreenCTM();
    const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse());
    return [x, y];
  }

  #under(event) {
    const drag = this.studio.story?.can.drag ?? [];
    if (!this.film || !drag.length) return null;
    const [x, y] = this.#point(event);
    const reach = this.#size / 7;
    const near = drag
      .map((who) => ({ who, at: this.#at(who) }))
      .filter(({ at }) => at)
      .map(({ who, at }) => ({ who, away: Math.hypot(at[0] - x, at[1] - y) }))
      .sort((a, b) => a.away - b.away)[0];
    return near && near.away < reach ? near.who : null;
  }

  #hover(event) {
    if (this.#placing || event.buttons) return;
    this.host.classList.toggle("graspable", this.#under(event) !== null);
  }

  async #press(event) {
    if (event.button !== 0 || !this.film) return;
    if (this.#placing) {
      this.#near(this.#point(event));
      this.#let();
      return;
    }
    const who = this.#under(event);
    const [x, y] = [event.clientX, event.clientY];
    if (who === null) {
      this.#playback.toggle();
      return;
    }
    event.preventDefault();
    let moved = false;
    this.#begin(who);
    const placing = this.#placing;
    placing.held = true;
    const isHeld = () => this.#placing === placing; // it may be known meanwhile that there is no place
    follow(
      this.host,
      event,
      (next) => {
        moved ||= Math.hypot(next.clientX - x, next.clientY - y) > 5;
        if (moved && isHeld()) this.#near(this.#point(next), true);
      },
      (last, broken) => {
        placing.held = false;
        if (!isHeld()) return;
        if (broken) this.leave();
        else if (moved) this.#let();
        else this.host.focus(); // only pressed: a place can be chosen with a second press, or keys
      },
    );
  }

  /** Asks where somebody can be in the frame that is shown, and lights the places up. */
  async #begin(who) {
    this.leave();
    this.#playback.seek(this.frame);
    const placing = (this.#placing = { who, frame: this.frame, spots: null, near: null });
    this.#mark(who, true);
    this.#lift(placing);
    const reply = await this.studio.ask("i2p/play", { frame: placing.frame, who });
    if (this.#placing !== placing) return;
    if (!reply) return this.leave();
    if (reply.room) this.#open(placing, reply.room);
    placing.spots = reply.spots.map((spot) => ({
      ...spot,
      node: s("polygon", {
        class: isOpen(spot) ? "spot" : "spot not",
        points: (spot.shape ?? []).map((point) => point.join(",")).join(" "),
        "data-place": spot.place ?? "",
      }),
    }));
    this.#layer.prepend(...placing.spots.filter(({ at }) => at).map(({ node }) => node));
    this.away.hidden = !placing.spots.some((spot) => !spot.at && isOpen(spot));
    const count = placing.spots.filter(isOpen).length;
    const where = placing.room ? "anywhere that is lit" : `in ${count} places`;
    this.#say(`${who} can be ${where} in frame ${placing.frame}. Arrow keys choose, Enter pins.`);
    if (placing.waits) placing.waits();
    else if (focusedBeside(this.cast)?.dataset.who === who) {
      this.host.focus();
      this.#near(this.#at(who, placing.frame) ?? placing.spots[0]?.at ?? [0, 0]);
    } else if (placing.pointer) this.#near(placing.pointer, true);
  }

  /** Lights up what lies between the spots, where somebody can be anywhere. */
  #open(placing, room) {
    placing.room = room;
    placing.home = this.#at(placing.who, placing.frame);
    const { x, y, width, height } = this.#playback.svg.viewBox.baseVal;
    if (room.reached) {
      const boxes = room.reached.map(([a, b, w, h]) => `M${a} ${b}h${w}v${h}h${-w}z`).join("");
      placing.lit = [
        s("rect", { class: "spot not", x, y, width, height }),
        s("path", { class: "spot room", d: boxes }),
      ];
    } else if (placing.home) {
      const [dx, dy] = room.along.map((each) => each * width);
      const [a, b] = placing.home;
      placing.lit = [s("path", { class: "spot way", d: `M${a - dx} ${b - dy}L${a + dx} ${b + dy}` })];
    }
    placing.target = s("circle", { class: "target", r: this.#size / 70 });
    this.#layer.prepend(...(placing.lit ?? []));
    this.#above.append(placing.target);
  }

  // The one who is moved hangs on the pointer; where that cannot be drawn, only places light up.
  #lift(placing) {
    const { root, svg } = this.#playback;
    const body =
      root.querySelector(`[data-actor="${CSS.escape(placing.who)}"]`) ?? root.querySelector(".cast");
    if (!body) return;
    placing.body = body;
    placing.ghost = body.cloneNode(true);
    placing.ghost.removeAttribute("data-actor");
    placing.ghost.removeAttribute("data-index");
    placing.home = this.#at(placing.who, placing.frame);
    placing.lay = svg.getCTM().inverse().multiply(body.getCTM());
    placing.ghost.classList.add("ghost");
    placing.ghost.style.display = "none";
    svg.append(placing.ghost);
  }

  /** The point next to a pointer at which somebody can be put. */
  #free([x, y], { room, home }) {
    const { x: left, y: top, width, height } = this.#playback.svg.viewBox.baseVal;
    const inside = [clamp(x, left, left + width), clamp(y, top, top + height)];
    if (!room.along || !home) return inside;
    const [dx, dy] = room.along;
    const far = (inside[0] - home[0]) * dx + (inside[1] - home[1]) * dy;
    return [home[0] + far * dx, home[1] + far * dy];
  }

  #isReached([x, y], { reached }) {
    return reached?.some(([a, b, w, h]) => a <= x && x <= a + w && b <= y && y <= b + h) ?? true;
  }

  #near([x, y], carried = false) {
    const placing = this.#placing;
    placing.pointer = [x, y];
    const { room, lay } = placing;
    const [px, py] = (placing.point = room ? this.#free([x, y], placing) : [x, y]);
    if (placing.ghost && placing.home) {
      const { a, b, c, d, e, f } = lay;
      const [dx, dy] = [px - placing.home[0], py - placing.home[1]];
      placing.ghost.setAttribute("transform", `matrix(${[a, b, c, d, e + dx, f + dy].join(" ")})`);
      placing.ghost.style.display = carried ? "" : "none";
      placing.body.classList.toggle("lifted", carried);
    }
    if (!placing.spots) return;
    const nearest = placing.spots
      .filter(({ at }) => at)
      .map((spot) => ({ spot, away: Math.hypot(spot.at[0] - x, spot.at[1] - y) }))
      .sort((a, b) => a.away - b.away)[0];
    const reach = this.#size / (room ? 24 : 6); // where all is open, only who is dropped on a spot is at it
    const within = nearest && nearest.away < reach ? nearest.spot : null;
    this.#choose(within);
    if (!room) return;
    const open = within ? isOpen(within) : this.#isReached(placing.point, room);
    const [cx, cy] = within?.at ?? placing.point;
    placing.target.classList.toggle("not", !open);
    placing.target.setAttribute("cx", cx);
    placing.target.setAttribute("cy", cy);
  }

  #choose(spot) {
    const placing = this.#placing;
    placing.near?.node.classList.remove("near");
    placing.near = spot;
    spot?.node.classList.add("near");
  }

  /** The one who is held is let go. */
  #let() {
    const placing = this.#placing;
    if (!placing.spots) {
      placing.waits = () => {
        if (placing.pointer) this.#near(placing.pointer, true);
        this.#let();
      };
      return;
    }
    const { near, who, frame, room, point } = placing;
    const film = this.film.id;
    this.leave();
    if (!near && !(room && point)) return;
    if (!(near ? isOpen(near) : this.#isReached(point, room))) {
      this.studio.tell(`${who} cannot be there in frame ${frame}: no way leads there in time.`);
      return;
    }
    this.#say(`${who} is pinned in frame ${frame}.`);
    const place = near ? { place: near.place } : { film, at: point };
    this.studio.byHand("i2p/pin", { frame, who, ...place });
  }

  /** The one who looks for a place is nowhere. */
  #away() {
    this.#choose(this.#placing.spots.find(({ at }) => !at));
    this.#let();
  }

  /** Ends the search for a place without one. */
  leave() {
    const placing = this.#placing;
    if (!placing) return;
    this.#placing = null;
    placing.ghost?.remove();
    placing.body?.classList.remove("lifted");
    for (const { node } of placing.spots ?? []) node.remove();
    for (const node of [...(placing.lit ?? []), placing.target]) node?.remove();
    this.away.hidden = true;
    this.#mark(placing.who, false);
    this.#drawPins();
    const pending = this.#pending;
    this.#pending = null;
    if (pending) this.show(pending);
  }

  #mark(who, on) {
    for (const chip of this.cast.querySelectorAll("[data-who]")) {
      chip.setAttribute("aria-pressed", String(on && chip.dataset.who === who));
    }
  }

  #say(text) {
    this.said.textContent = text;
  }

  #key(event) {
    const placing = this.#placing;
    if (!placing) return;
    const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    if (event.key === "Escape") this.leave();
    else if (event.key === "Enter" || event.key === " ") this.#let();
    else if (steps[event.key] && placing.spots) this.#walk(...steps[event.key]);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  /** Goes to the possible place that lies nearest in a direction. */
  #walk(dx, dy) {
    const { near, spots, room, point } = this.#placing;
    const [x, y] = near?.at ?? point ?? [0, 0];
    if (room) {
      const step = this.#size / 30;
      this.#near([x + dx * step, y + dy * step], true);
      return;
    }
    const ahead = spots
      .filter((spot) => spot.at && isOpen(spot) && spot !== near)
      .map((spot) => {
        const [along, aside] = [
          (spot.at[0] - x) * dx + (spot.at[1] - y) * dy,
          Math.abs((spot.at[0] - x) * dy + (spot.at[1] - y) * dx),
        ];
        return { spot, along, cost: along + 3 * aside };
      })
      .filter(({ along }) => along > 1e-6)
      .sort((a, b) => a.cost - b.cost)[0];
    if (!ahead) return;
    this.#choose(ahead.spot);
    this.#placing.pointer = ahead.spot.at;
    this.#say(`${ahead.spot.place ?? ahead.spot.label}`);
  }
}
