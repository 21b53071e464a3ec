// What leaves the studio: the film and its pictures, made by the server and fetched from it.
import { $, fill, h } from "./dom.js";

const FORMATS = {
  mp4: ["Film", "MP4"],
  gif: ["Film for chats", "GIF"],
  webm: ["Film for the web", "WebM"],
  png: ["Comic strip", "PNG"],
  svg: ["Comic strip to edit", "SVG"],
  html: ["Page with player and beliefs", "HTML"],
  sheet: ["Sprite sheet", "PNG and JSON"],
  timeline: ["Timeline as data", "JSON"],
  godot: ["For Godot", "sheet, timeline, script"],
};

const isAll = ({ name }) => name.endsWith(".zip");
const size = (file) => Math.max(1, Math.round(file.size / 1024)).toLocaleString();

export class Out {
  constructor(studio) {
    this.studio = studio;
    this.dialog = $("exports");
  }

  open() {
    const { film, story } = this.studio;
    if (!film) return;
    const offered = story?.can.formats ?? this.studio.formats;
    const boxes = offered.map((format) =>
      h(
        "label",
        { class: "format" },
        h("input", { type: "checkbox", name: "format", value: format, checked: format === "mp4" }),
        h("span", {}, FORMATS[format]?.[0] ?? format),
        h("small", {}, FORMATS[format]?.[1] ?? ""),
      ),
    );
    const pace = h("input", {
      type: "range",
      min: 0.5,
      max: 3,
      step: 0.25,
      value: 1,
      "aria-label": "Pace",
    });
    const told = h("output", {}, "1×");
    pace.addEventListener("input", () => (told.textContent = `${pace.value}×`));
    const clear = h("input", { type: "checkbox" });
    const made = h("div", { class: "made", role: "status" });
    const make = h("button", { type: "submit", class: "main-button" }, "Make them");
    const submit = async (event) => {
      event.preventDefault();
      const formats = boxes
        .filter((box) => box.firstChild.checked)
        .map((box) => box.firstChild.value);
      if (!formats.length) return;
      make.disabled = true;
      fill(made, h("p", { class: "hint" }, "Being made: films take some seconds …"));
      const params = { formats, pace: Number(pace.value), transparent: clear.checked };
      const reply = await this.studio.ask("i2p/export", params, film);
      make.disabled = false;
      fill(
        made,
        reply
          ? h(
              "ul",
              {},
              // The archive of all that were made first.
              [...reply.files].sort((one, other) => isAll(other) - isAll(one)).map((file) =>
                h(
                  "li",
                  { class: isAll(file) ? "all" : null },
                  h("a", { href: file.url, download: file.name }, file.name),
                  h("small", {}, ` ${size(file)} kB${isAll(file) ? ", all of them" : ""}`),
                ),
              ),
            )
          : h("p", { class: "hint" }, "They could not be made."),
      );
    };
    fill(
      this.dialog,
      h(
        "div",
        { class: "dialog-head" },
        h("h2", { id: "exports-heading" }, "Export"),
        h("button", { type: "button", class: "quiet", click: () => this.dialog.close() }, "Close"),
      ),
      h(
        "form",
        { submit },
        h("div", { class: "formats" }, boxes),
        h("label", { class: "slide" }, h("span", {}, "Pace"), pace, told),
        story?.can.transparent
          ? h(
              "label",
              { class: "format" },
              clear,
              h("span", {}, "Only who acts, on nothing"),
              h("small", {}, "GIF, WebM"),
            )
          : null,
        h(
          "p",
          { class: "acts" },
          make,
          h(
            "button",
            { type: "button", class: "quiet", click: () => this.studio.keep(film) },
            "Keep the script beside the story",
          ),
        ),
      ),
      made,
    );
    this.dialog.showModal();
  }
}
