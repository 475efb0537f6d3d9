// Pictures of the WebSocket: a header of 16 bytes, then a JPEG or WebP. Only the newest is drawn.

export const HEADER_BYTES = 16;
const FORMATS = { 1: "image/jpeg", 2: "image/webp" };

/** What a binary message holds; throws a RangeError for one that is no picture. */
export function parsePicture(buffer) {
  if (buffer.byteLength <= HEADER_BYTES) throw new RangeError(`a picture of ${buffer.byteLength} bytes`);
  const header = new DataView(buffer, 0, HEADER_BYTES);
  const [frame, seq, simulatedMs, format] = [0, 4, 8, 12].map((at) => header.getUint32(at, true));
  if (!(format in FORMATS)) throw new RangeError(`a picture of the unknown format ${format}`);
  return { frame, seq, simulatedMs, type: FORMATS[format], bytes: new Uint8Array(buffer, HEADER_BYTES) };
}

/** The canvas on which pictures appear, and what of them waits to be drawn. */
export class Screen {
  constructor(decode = (blob) => createImageBitmap(blob)) {
    this.canvas = document.createElement("canvas");
    this.canvas.setAttribute("role", "img");
    this.context = this.canvas.getContext("2d", { alpha: false, desynchronized: true });
    this.decode = decode;
    this.waiting = null; // decoded, not yet drawn
    this.newest = 0; // the highest frame that was drawn or dropped
    this.acknowledged = 0;
    this.page = 0; // pictures of an earlier page are not drawn
    this.empty = true;
  }

  /** Forgets what is shown: the next page may have another view, of which nothing old may be seen. */
  clear() {
    this.page += 1;
    this.waiting?.bitmap.close();
    this.waiting = null;
    this.empty = true;
    this.context.fillRect(0, 0, this.canvas.width, this.canvas.height);
  }

  /** Decodes a binary message. A picture that comes late, or of an earlier page, or damaged, is dropped. */
  async receive(buffer) {
    const page = this.page;
    const { frame, seq, type, bytes } = parsePicture(buffer);
    let bitmap = null;
    try {
      bitmap = await this.decode(new Blob([bytes], { type }));
    } catch {
      // It is acknowledged as if drawn, without a latency; the server would wait for it for ever.
    }
    if (bitmap && page === this.page && frame > this.newest) {
      this.waiting?.bitmap.close();
      this.waiting = { frame, seq, bitmap };
    } else {
      bitmap?.close();
    }
    this.newest = Math.max(this.newest, frame);
  }

  /** Draws the newest picture, to be called once an animation frame.
   *
   * Returns what there is to acknowledge, {frame, seq}, with seq null where nothing was drawn; else null.
   */
  draw() {
    const drawn = this.waiting;
    if (drawn) {
      this.waiting = null;
      this.empty = false;
      const { width, height } = drawn.bitmap;
      if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
      this.context.drawImage(drawn.bitmap, 0, 0);
      drawn.bitmap.close();
    }
    if (this.newest === this.acknowledged) return null;
    this.acknowledged = this.newest;
    return { frame: this.newest, seq: drawn?.seq ?? null };
  }
}
