// Keeps the page up to date: follows the service's event stream, reconnects when it breaks, and also polls at
// intervals. The stream is read with `fetch`, because `EventSource` cannot send a token in a header.

import { ask, has } from "./api.js";
import { EventParser } from "./sse.js";

/** Polling intervals with an event stream, and for a service without one. */
const LOOK_MS = 10_000;
const POLL_MS = 2_000;
/** Changes within this time cause one refresh. */
const GATHER_MS = 150;
/** Shortest time between two refreshes. */
const PAUSE_MS = 1_000;
const RETRY_MS = { first: 500, last: 15_000 };
/** The service sends data at least this often. */
const SILENCE_MS = 60_000;

export class Live {
  #onChange;
  #onState;
  #onEvent;
  #state = "";
  #lastId = null;
  #retries = 0;
  #timer = 0;
  #gathering = 0;
  #lookedAt = 0;
  #abort = null;
  #streaming = null;
  #wake = null;
  #isListening = false;

  /**
   * `onChange()` is called after changes, `onState(state)` when the connection's state changes, and `onEvent({ event, data })`
   * for each event.
   */
  constructor(onChange, onState, onEvent) {
    this.#onChange = onChange;
    this.#onState = onState;
    this.#onEvent = onEvent;
  }

  /** Starts, also again after a sign-in. */
  start() {
    this.stop();
    this.#abort = new AbortController();
    this.#isListening = false;
    this.#begin();
    this.#look();
  }

  /** Opens the stream once the service is known to have one. */
  #begin() {
    if (this.#isListening || !this.#abort || this.#abort.signal.aborted || !has("GET", "/v1/events")) return;
    this.#isListening = true;
    this.#streaming = new AbortController();
    this.#listen(AbortSignal.any([this.#abort.signal, this.#streaming.signal]));
  }

  /**
   * Closes the stream of a page out of sight: a browser has six connections to a host, and each open page would keep one. The next
   * answer opens it again.
   */
  rest() {
    this.#streaming?.abort();
    this.#isListening = false;
  }

  stop() {
    this.#abort?.abort();
    clearTimeout(this.#timer);
    clearTimeout(this.#gathering);
    this.#gathering = 0;
  }

  /** Retries at once, because the network or the page is back. */
  hurry() {
    this.#wake?.();
    this.#gather();
  }

  /** Notes whether a request of the page was answered, which also tells whether the service is reachable. */
  told(isAnswered) {
    if (!isAnswered) this.#tell("offline");
    else if (!has("GET", "/v1/events")) this.#tell("polling");
    else if (this.#state === "offline") this.#tell("reconnecting");
    if (!isAnswered) return;
    // After a sign-in in another tab.
    if (this.#abort?.signal.aborted) this.start();
    else this.#begin();
  }

  #tell(state) {
    if (state === this.#state) return;
    this.#state = state;
    this.#onState(state);
  }

  #look() {
    const every = has("GET", "/v1/events") ? LOOK_MS : POLL_MS;
    this.#timer = setTimeout(() => {
      if (!document.hidden) this.#onChange();
      this.#look();
    }, every);
  }

  #gather() {
    if (this.#gathering) return;
    const wait = Math.max(GATHER_MS, this.#lookedAt + PAUSE_MS - Date.now());
    this.#gathering = setTimeout(() => {
      this.#gathering = 0;
      this.#lookedAt = Date.now();
      if (!document.hidden) this.#onChange();
    }, wait);
  }

  async #listen(stopped) {
    while (!stopped.aborted) {
      try {
        await this.#stream(stopped);
      } catch (problem) {
        if (stopped.aborted) return;
        // The page asks for a sign-in, also out of sight, and that ends this stream.
        if (problem.status === 401 || problem.status === 403) this.#onChange();
        else this.#tell(problem.isSilence || !navigator.onLine ? "offline" : "reconnecting");
      }
      if (stopped.aborted) return;
      // The service ends each stream after a while. Only a failed attempt changes the state.
      await this.#pause();
    }
  }

  async #stream(stopped) {
    const broken = new AbortController();
    const signal = AbortSignal.any([stopped, broken.signal]);
    const headers = { Accept: "text/event-stream" };
    if (this.#lastId !== null) headers["Last-Event-ID"] = this.#lastId;
    const answer = await ask("/v1/events", { headers, signal });
    const reader = answer.body.pipeThrough(new TextDecoderStream()).getReader();
    const parser = new EventParser();
    this.#tell("live");
    // Changes before the connection may have been missed.
    this.#gather();
    for (;;) {
      const silence = setTimeout(() => broken.abort(), SILENCE_MS);
      const { done, value } = await reader.read().finally(() => clearTimeout(silence));
      if (done) return;
      this.#tell("live");
      this.#retries = 0;
      parser.push(value).forEach((event) => this.#heard(event));
    }
  }

  #heard(told) {
    const { event, id } = told;
    this.#onEvent(told);
    if (id !== null) this.#lastId = id;
    if (event === "reset") this.#lastId = null;
    this.#gather();
  }

  async #pause() {
    const longest = Math.min(RETRY_MS.last, RETRY_MS.first * 2 ** this.#retries);
    this.#retries += 1;
    await new Promise((resolve) => {
      this.#wake = resolve;
      setTimeout(resolve, longest * (0.5 + Math.random() / 2));
    });
    this.#wake = null;
  }
}
