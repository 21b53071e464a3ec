// The film's time: to play and to go along it, with pins and the story's own moments on it.
import { clamp, focusedBeside, follow, h, icon, s } from "./dom.js";
import { During } from "./during.js";

const SPEEDS = [0.5, 1, 2, 4];
const AWAY = 46; // pixels up or down at which a pin is dragged away
const LABEL = 44; // pixels that a pin's name takes, about
const MOST_ROWS = 4;
const EDGE = 9; // pixels at the ends of a long pin that make it longer or shorter

export class Timeline {
  #pins = h("div", {
    class: "lane pins",
    role: "group",
    "aria-label": "Pins",
    title: "Drag along here to pin a stretch of frames",
    pointerdown: (event) => this.#stretch(event),
  });

  #marking = h("div", { class: "marking", hidden: true });
  #moments = h("div", {
    class: "lane moments",
    role: "group",
    "aria-label": "Moments of the story",
  });

  #beats = h("div", { class: "lane beats", role: "group", "aria-label": "Beats" });

  constructor(host, studio) {
    this.studio = studio;
    this.host = host;
    const button = (name, path, act, more = {}) =>
      h(
        "button",
        { type: "button", "aria-label": name, title: name, click: act, ...more },
        icon(path),
      );
    this.play = h(
      "button",
      {
        type: "button",
        class: "main",
        "aria-label": "Play",
        title: "Play or pause (space)",
        click: () => this.toggle(),
      },
      s(
        "svg",
        { viewBox: "0 0 24 24", "aria-hidden": "true" },
        s("path", { class: "when-paused", d: "M8 4.5v15L20 12z" }),
        s("path", { class: "when-playing", d: "M7 5h3.5v14H7zM13.5 5H17v14h-3.5z" }),
      ),
    );
    this.scrubber = h("input", {
      type: "range",
      id: "scrubber",
      "aria-label": "Frame",
      min: 0,
      max: 1,
      step: 0.01,
      value: 0,
      input: (event) => this.#scrub(Number(event.target.value)),
    });
    this.counter = h("output", { class: "counter", for: "scrubber" }, "0 / 0");
    this.speed = h(
      "select",
      {
        "aria-label": "Speed",
        change: () => this.studio.playback?.setSpeed(Number(this.speed.value)),
      },
      SPEEDS.map((each) => h("option", { value: each }, `${each}×`)),
    );
    this.speed.value = "1";
    const hand = (what) => () =>
      this.studio.byHand("i2p/edit", { what, frame: Math.max(1, this.studio.frame) });
    this.holds = h(
      "button",
      {
        type: "button",
        class: "quiet",
        title: "Pins all up to this frame as it is; what comes after is found anew",
        click: () => this.#hold(),
        "aria-label": "Hold to here",
      },
      "Hold",
      h("span", { class: "more" }, " to here"),
    );
    this.tools = h(
      "div",
      { class: "turns", role: "group", "aria-label": "Turns" },
      h(
        "button",
        {
          type: "button",
          class: "quiet",
          title: "Adds a turn before this frame",
          click: hand("insert"),
        },
        "+ turn",
      ),
      h(
        "button",
        {
          type: "button",
          class: "quiet",
          title: "Takes this frame’s turn out",
          click: hand("cut"),
        },
        "− turn",
      ),
      h(
        "button",
        {
          type: "button",
          class: "quiet",
          title: "Pins what shall hold in several frames",
          click: () => this.during.open(),
          "aria-label": "Pin a stretch",
        },
        h("span", { class: "more" }, "Pin a "),
        "stretch",
      ),
      this.holds,
    );
    host.append(
      h("div", { class: "track" }, this.#beats, this.#moments, this.scrubber, this.#pins),
      h(
        "div",
        { class: "transport" },
        h(
          "div",
          { class: "buttons" },
          button("To the start", "M6 5v14M19 5.5v13L9 12z", () => this.seek(0)),
          button("Back one frame", "M15 5l-7 7 7 7", () => this.step(-1)),
          this.play,
          button("Forward one frame", "M9 5l7 7-7 7", () => this.step(1)),
        ),
        this.counter,
        this.speed,
        this.tools,
      ),
    );
    this.during = new During(host, studio);
    this.during.marked = () => this.#mark(this.during.frames);
    this.setFilm(null);
  }

  setFilm(film) {
    this.last = film?.play.last ?? 0;
    this.scrubber.max = Math.max(this.last, 1);
    this.scrubber.disabled = !film;
    for (const each of this.tools.children) each.disabled = !film;
    if (!film) this.during.close();
    this.#frame = -1;
    this.show(this.studio.time);
    this.refresh();
  }

  show(time) {
    const frame = Math.ceil(time - 1e-9);
    this.scrubber.value = time;
    this.scrubber.style.setProperty("--done", `${(100 * time) / Math.max(this.last, 1)}%`);
    const playing = this.studio.playback?.isPlaying ?? false;
    this.play.classList.toggle("playing", playing);
    if (frame === this.#frame) return;
    this.#frame = frame;
    this.counter.textContent = `${frame} / ${this.last}`;
    this.scrubber.setAttribute(
      "aria-valuetext",
      frame ? `frame ${frame} of ${this.last}` : "start",
    );
  }

  #frame = -1;

  setPlaying(playing) {
    this.play.classList.toggle("playing", playing);
    this.play.setAttribute("aria-label", playing ? "Pause" : "Play");
  }

  seek = (time) => this.studio.playback?.seek(time);
  step = (by) => this.studio.playback?.step(by);
  toggle = () => this.studio.playback?.toggle();

  #scrub(time) {
    const whole = Math.round(time);
    this.seek(Math.abs(time - whole) < 0.15 ? whole : time); // whole frames hold on to the thumb
  }

  #hold() {
    const last = Math.max(1, this.studio.frame);
    const film = this.studio.film.id;
    this.studio.byHand("i2p/hold", { film, first: 1, last });
  }

  // ------------------------------------------------------------------ pins and moments

  /** Draws pins and moments as the text has them. */
  refresh() {
    const { pins = [], numbers = [], beats = [] } = this.studio.story ?? {};
    const focused = focusedBeside(this.host)?.dataset.key;
    const rows = this.#rows(pins);
    this.#pins.replaceChildren(this.#marking, ...pins.map((pin, i) => this.#pin(pin, i)));
    [...this.#pins.children].slice(1).forEach((node, i) => node.style.setProperty("--row", rows[i]));
    this.#pins.style.setProperty("--rows", Math.max(0, ...rows) + 1);
    this.holds.hidden = !(this.studio.story?.can.hold ?? true);
    const moments = numbers.filter(({ frame }) => frame !== null && frame !== undefined);
    this.#moments.replaceChildren(...moments.map((moment, i) => this.#moment(moment, i)));
    this.#beats.replaceChildren(...beats.map((beat, i) => this.#beat(beat, i, beats.length)));
    if (focused) this.host.querySelector(`[data-key="${CSS.escape(focused)}"]`)?.focus();
  }

  /** The row of each pin: those that would lie on each other lie below each other. */
  #rows(pins) {
    const ends = []; // of each row
    const wide = Math.ceil((this.last * LABEL) / Math.max(this.#pins.clientWidth, 1));
    const rows = new Array(pins.length).fill(0);
    const order = [...pins.keys()].sort((a, b) => pins[a].frame - pins[b].frame);
    for (const i of order) {
      const { frame, last = frame } = pins[i];
      const free = ends.findIndex((end) => end < frame);
      rows[i] = free >= 0 ? free : Math.min(ends.length, MOST_ROWS - 1);
      ends[rows[i]] = Math.max(last, frame + wide);
    }
    return rows;
  }

  #left = (frame) => `${(100 * clamp(frame, 0, this.last)) / Math.max(this.last, 1)}%`;

  #place(node, frame) {
    node.style.left = this.#left(frame);
    return node;
  }

  #pin(pin, i) {
    const { frame, last = frame, who, text } = pin;
    const where = frame === last ? `frame ${frame}` : `frames ${frame} to ${last}`;
    const node = h(
      "button",
      {
        type: "button",
        class: "mark",
        "data-key": `pin-${i}`,
        "data-frame": frame,
        "data-who": who ?? "",
        "aria-label": `Pin in ${where}: ${text}. Drag it, or use arrow keys; Delete takes it away`,
        title: `${where}: ${text}`,
        pointerdown: (event) => {
          const box = node.getBoundingClientRect();
          const [left, right] = [event.clientX - box.left, box.right - event.clientX];
          const end = last > frame ? (left < EDGE ? "first" : right < EDGE ? "last" : null) : null;
          if (end) return this.#pull(event, pin, end);
          this.#drag(
            event,
            node,
            frame,
            (to) => this.#move(pin, to),
            () => this.#unpin(pin),
          );
        },
        dblclick: () => this.studio.text.reveal(pin.range),
        keydown: (event) => {
          const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
          if (by && event.shiftKey && last + by > frame) this.#reach(pin, frame, last + by);
          else if (by) this.#move(pin, clamp(frame + by, 1, this.last));
          else if (event.key === "Delete" || event.key === "Backspace") this.#unpin(pin);
          else return;
          event.preventDefault();
          event.stopPropagation();
        },
      },
      who ?? (last > frame ? text : ""),
    );
    if (last > frame) {
      node.style.width = `calc(${(100 * (last - frame)) / Math.max(this.last, 1)}% + 1.1rem)`;
      node.classList.add("long");
    }
    return this.#place(node, frame);
  }

  #move(pin, to) {
    const { frame, last = frame, who } = pin;
    if (to === frame) return;
    if (last > frame) this.#reach(pin, to, to + last - frame);
    else this.studio.byHand("i2p/move", { frame, who: who ?? "", to });
  }

  /** A pin of several frames is one of others. */
  #reach({ frames }, first, last) {
    const end = clamp(last, 1, this.last);
    const begin = clamp(first, 1, end);
    this.studio.text.rewrite(frames, begin === end ? `${begin}` : `${begin}..${end}`);
  }

  /** One end of a long pin is pulled. */
  #pull(event, pin, end) {
    if (event.button !== 0) return;
    let frames = [pin.frame, pin.last];
    const move = (next) => {
      const at = clamp(this.#frameAt(next), 1, this.last);
      frames = end === "first" ? [Math.min(at, pin.last), pin.last] : [pin.frame, Math.max(at, pin.frame)];
      this.#mark(frames);
      this.seek(at);
    };
    follow(event.target, event, move, (_, broken) => {
      this.#mark(this.during.frames);
      if (!broken && (frames[0] !== pin.frame || frames[1] !== pin.last)) this.#reach(pin, ...frames);
    });
  }

  #frameAt(event) {
    const { left, width } = this.#pins.getBoundingClientRect();
    return Math.round(((event.clientX - left) / width) * this.last);
  }

  /** Shows which frames are meant. */
  #mark(frames) {
    this.#marking.hidden = frames === null;
    if (frames === null) return;
    const [first, last] = frames;
    this.#marking.style.left = this.#left(first);
    this.#marking.style.width = `${(100 * Math.max(0, last - first)) / Math.max(this.last, 1)}%`;
  }

  /** A stretch is marked between the pins. */
  #stretch(event) {
    if (event.button !== 0 || event.target !== this.#pins || !this.studio.film) return;
    const from = clamp(this.#frameAt(event), 1, this.last);
    let to = from;
    const ends = () => [Math.min(from, to), Math.max(from, to)];
    follow(
      this.#pins,
      event,
      (next) => {
        to = clamp(this.#frameAt(next), 1, this.last);
        this.#mark(ends());
        this.seek(to);
      },
      (_, broken) => {
        this.#mark(this.during.frames);
        if (!broken && to !== from) this.during.open(...ends());
      },
    );
  }

  #unpin({ frame, last = frame, who }) {
    const together = last > frame ? { last } : {};
    this.studio.byHand("i2p/unpin", { frame, who: who ?? null, ...together });
  }

  #moment(moment, i) {
    const { frame, what, range, prefix } = moment; // `prefix`: where a pattern's usual moment is meant
    const rewrite = (to) => {
      if (to !== frame) this.studio.text.rewrite(range, `${prefix}${to}`);
    };
    const node = h("button", {
      type: "button",
      class: "moment",
      "data-key": `moment-${i}`,
      "data-frame": frame,
      "aria-label": `${what} in frame ${Math.round(frame)}. Drag it, or use arrow keys`,
      title: `${what}: frame ${Math.round(frame)}`,
      pointerdown: (event) => this.#drag(event, node, frame, rewrite),
      keydown: (event) => {
        const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
        if (!by) return;
        event.preventDefault();
        event.stopPropagation();
        rewrite(clamp(Math.round(frame) + by, 0, this.last));
      },
    });
    return this.#place(node, frame);
  }

  /** A beat of the story: dragged, or with arrow keys, it changes its place among the others. */
  #beat({ text, range }, i, count) {
    const reorder = (to) => {
      if (to === i || to < 0 || to >= count) return;
      const order = [...Array(count).keys()].filter((each) => each !== i);
      order.splice(to, 0, i);
      this.studio.byHand("i2p/edit", { what: "beats", order });
    };
    const node = h(
      "button",
      {
        type: "button",
        "data-key": `beat-${i}`,
        "aria-label": `Beat ${i + 1}: ${text}. Drag it, or use arrow keys`,
        title: text,
        dblclick: () => this.studio.text.reveal(range),
        keydown: (event) => {
          const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
          if (!by) return;
          event.preventDefault();
          event.stopPropagation();
          reorder(i + by);
        },
        pointerdown: (event) => {
          if (event.button !== 0) return;
          const x = event.clientX;
          const { width } = node.getBoundingClientRect();
          let away = 0;
          follow(
            node,
            event,
            (next) => {
              away = next.clientX - x;
              node.classList.add("held");
              node.style.translate = `${away}px 0`;
            },
            (_, broken) => {
              node.classList.remove("held");
              node.style.translate = "";
              if (!broken) reorder(clamp(i + Math.round(away / width), 0, count - 1));
            },
          );
        },
      },
      text,
    );
    return node;
  }

  #drag(event, node, frame, moved, removed = null) {
    if (event.button !== 0) return;
    const track = node.parentNode.getBoundingClientRect();
    const [x, y] = [event.clientX, event.clientY];
    let [to, gone, began] = [frame, false, false];
    follow(
      node,
      event,
      (next) => {
        began ||= Math.hypot(next.clientX - x, next.clientY - y) > 4;
        if (!began) return;
        to = clamp(
          Math.round(frame + ((next.clientX - x) / track.width) * this.last),
          removed ? 1 : 0,
          this.last,
        );
        gone = removed !== null && Math.abs(next.clientY - y) > AWAY;
        node.classList.toggle("gone", gone);
        this.#place(node, to);
        if (!gone) this.seek(to);
      },
      (_, broken) => {
        this.#place(node, frame);
        node.classList.remove("gone");
        if (broken) return;
        if (!began) this.seek(frame);
        else if (gone) removed();
        else moved(to);
      },
    );
  }
}
