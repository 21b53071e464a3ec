// What stage, time line and curves ask of whatever they stand in: the studio's page (main.js), or a
// cell of a notebook (widget.js). It has a `text`, a `stage`, and a `request`.
export class Desk {
  story = null; // what `i2p/story` says of the present text, or said of the last one that was right

  get film() {
    return this.stage?.film ?? null;
  }

  get playback() {
    return this.stage?.playback ?? null;
  }

  get time() {
    return this.stage?.time ?? 0;
  }

  get frame() {
    return Math.round(this.time);
  }

  get pins() {
    return this.story?.pins ?? [];
  }

  /** Whether a message is about the text as it is. */
  isPresent({ uri, version }) {
    return uri === this.text.uri && version === this.text.version;
  }

  /** A request about the present text, or about a film. */
  ask(method, params, film = null) {
    this.text.flush();
    const about = film ? { film: film.id } : { uri: this.text.uri, version: this.text.version };
    return this.request(method, { ...about, ...params });
  }
}
