// Elements made short. Nothing here takes HTML from a text.

const SVG = "http://www.w3.org/2000/svg";
const AS_PROPERTY = new Set(["value", "checked", "hidden", "disabled", "textContent", "open"]);

function filled(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (typeof value === "function") node.addEventListener(name, value);
    else if (AS_PROPERTY.has(name)) node[name] = value;
    else node.setAttribute(name, value === true ? "" : value);
  }
  node.append(...given(children));
  return node;
}

const given = (children) =>
  children
    .flat(Infinity)
    .filter((child) => child !== null && child !== undefined && child !== false);

/** Puts children in place of those that a node has. */
export const fill = (node, ...children) => node.replaceChildren(...given(children));

/** An HTML element: attributes by name, listeners as functions by the event's name. */
export const h = (tag, attributes = {}, ...children) =>
  filled(document.createElement(tag), attributes, children);

/** The same of SVG. */
export const s = (tag, attributes = {}, ...children) =>
  filled(document.createElementNS(SVG, tag), attributes, children);

/** What has the focus beside a node, in its shadow root if it is in one. */
export const focusedBeside = (node) => node.getRootNode().activeElement ?? null;

export const $ = (id) => document.getElementById(id);

/** A number for people to read, of some digits. */
export const figure = (value, digits = 3) =>
  value === null || value === undefined
    ? "–"
    : String(
        Number(value.toPrecision(Math.max(digits, Math.trunc(value).toString().length))),
      ).replace("-", "−");

export const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

/** A button with an icon: `path` is drawn in 24 x 24 units. */
export const icon = (path, line = true) =>
  s(
    "svg",
    { viewBox: "0 0 24 24", "aria-hidden": "true" },
    s("path", { class: line ? "line" : "", d: path }),
  );

/** Calls `work` when `wait` milliseconds have passed since the last call. */
export function later(work, wait) {
  let timer = 0;
  const call = (...given) => {
    clearTimeout(timer);
    timer = setTimeout(() => work(...given), wait);
  };
  call.cancel = () => clearTimeout(timer);
  return call;
}

/** Follows a pointer from its press until it is let go. `move` and `end` get the event; `end` also
 * whether it was broken off (Escape, or the browser took the pointer). */
export function follow(node, event, move, end) {
  node.setPointerCapture(event.pointerId);
  const stop = (broken) => (last) => {
    for (const [kind, listener] of listeners) node.removeEventListener(kind, listener);
    removeEventListener("keydown", escape, true);
    end(last, broken);
  };
  const escape = (key) => {
    if (key.key !== "Escape") return;
    key.stopPropagation();
    stop(true)(event);
  };
  const listeners = [
    ["pointermove", move],
    ["pointerup", stop(false)],
    ["pointercancel", stop(true)],
  ];
  for (const [kind, listener] of listeners) node.addEventListener(kind, listener);
  addEventListener("keydown", escape, true);
}

/** Text with `code` in it, as nodes. */
export const prose = (text) =>
  text
    .split(/(`[^`]+`)/)
    .map((part) => (/^`.+`$/.test(part) ? h("code", {}, part.slice(1, -1)) : part));

/** What is fetched once and kept in `known`; what could not be had is asked for again next time. */
export function fetched(known, key, ask) {
  known[key] ??= ask().catch((problem) => {
    delete known[key];
    throw problem;
  });
  return known[key];
}

const sheets = {};

/** A stylesheet for shadow roots. */
export const sheetOf = (address) =>
  fetched(sheets, address, async () => {
    const reply = await fetch(address);
    return new CSSStyleSheet().replace(await reply.text());
  });
