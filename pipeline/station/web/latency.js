// How long it takes from the read of an input to the picture that shows what it did.

const LONGEST_MS = 60_000; // what the station takes; a machine that slept shows longer ones

/** Remembers when each input was read. */
export class Latency {
  constructor() {
    this.reads = new Map(); // by seq, milliseconds
  }

  read(seq, now) {
    this.reads.set(seq, now);
  }

  /** Milliseconds since the input seq was read; null where a picture before had it, or another page sent it. */
  drawn(seq, now) {
    const read = this.reads.get(seq);
    if (read === undefined) return null;
    for (const old of this.reads.keys()) if (old <= seq) this.reads.delete(old);
    return Math.min(now - read, LONGEST_MS);
  }
}
