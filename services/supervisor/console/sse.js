// Parser of a server's event stream (text/event-stream).

/** Extracts events from chunks of text, which may end anywhere. */
export class EventParser {
  #rest = "";
  #event = "";
  #data = [];
  #id = null;

  /** The events that a chunk completes: `{ event, data, id }`. */
  push(piece) {
    const lines = (this.#rest + piece).split(/\r\n|\n|\r(?=.)/s);
    this.#rest = lines.pop();
    return lines.map((line) => this.#line(line)).filter(Boolean);
  }

  #line(line) {
    if (line === "") return this.#dispatch();
    const [, field, value] = /^([^:]*):? ?(.*)$/s.exec(line);
    if (field === "data") this.#data.push(value);
    else if (field === "event") this.#event = value;
    else if (field === "id") this.#id = value;
    return null;
  }

  #dispatch() {
    const done = { event: this.#event || "message", data: this.#data.join("\n"), id: this.#id };
    const isEmpty = this.#data.length === 0;
    this.#event = "";
    this.#data = [];
    return isEmpty ? null : done;
  }
}
