// A story in a text field and its film: as much as shows that the server works.
import { mount } from "/render/page/player.js";

const $ = (id) => document.getElementById(id);
const socket = new WebSocket(`ws://${location.host}/socket`, ["i2p", `i2p.token.${location.hash.slice(1)}`]);
const waiting = new Map();
let count = 0, version = 0, uri = null;

const send = (message) => socket.send(JSON.stringify({ jsonrpc: "2.0", ...message }));
const ask = (method, params = {}) =>
  new Promise((resolve, reject) => {
    waiting.set(++count, { resolve, reject });
    send({ id: count, method, params });
  });
const solve = () =>
  ask("i2p/solve", { uri, version }).catch((error) => ($("state").textContent = error.message));

async function open(path) {
  const file = await ask("i2p/open", { path });
  uri = file.uri;
  $("text").value = file.text;
  send({ method: "textDocument/didOpen", params: { textDocument: { uri, languageId: file.language, version: ++version, text: file.text } } });
  solve();
}

async function show(film) {
  const { makeStage } = await import(`/render/${film.play.script}`);
  const root = $("film").attachShadow ? ($("film").shadowRoot ?? $("film").attachShadow({ mode: "open" })) : $("film");
  root.innerHTML = film.play.stage;
  mount(root, film.play, makeStage(film.play, root)).play();
  $("state").textContent = `${film.quality}, score ${film.score}`;
}

socket.addEventListener("message", ({ data }) => {
  const message = JSON.parse(data);
  if (message.id !== undefined && waiting.has(message.id)) {
    const { resolve, reject } = waiting.get(message.id);
    waiting.delete(message.id);
    if (message.error) reject(message.error);
    else resolve(message.result);
  } else if (message.method === "i2p/film") show(message.params.film);
  else if (message.method === "i2p/progress") $("state").textContent = message.params.text;
});
socket.addEventListener("open", async () => {
  await ask("initialize", { processId: null, rootUri: null, capabilities: {} });
  send({ method: "initialized", params: {} });
  const studio = await ask("i2p/studio");
  const { files } = await ask("i2p/files");
  const stories = files.filter((file) => file.kind === "story");
  $("files").append(...stories.map((file) => new Option(file.path, file.path)));
  $("files").onchange = () => open($("files").value);
  if (stories.length) open(studio.start ?? stories[0].path);
});
$("text").addEventListener("input", () => {
  send({ method: "textDocument/didChange", params: { textDocument: { uri, version: ++version }, contentChanges: [{ text: $("text").value }] } });
  solve();
});
