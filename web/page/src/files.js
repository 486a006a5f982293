// The captures as the decoder reads them: piece by piece from the user's files, with the next pieces read ahead while
// the decoder works on one. The buffers of pieces are reused: otherwise the garbage would soon exceed all other memory
// of the page.

const reader = new FileReaderSync();
/** Number of pieces of one file, and number of bytes in the pieces of all files. */
const PIECES = 4;
const MOST = 16 << 20;
/** Maximum and minimum number of bytes in a piece. */
const LONGEST = 1 << 20;
const SHORTEST = 64 << 10;

let files = [];
/** Bytes that are read in place of files, by their numbers. */
const lent = new Map();
/** The worker that hashes the files of the current choice; null if there is none. */
let hasher = null;
/** The worker that will hash the files of the next choice. */
let offered = null;
let choice = 0;
let hashed = () => {};

/** From the next choice on, read pieces go to this port and their buffers come back; without one, hashing ends now. */
export function hashBy(port) {
  offered = port;
  if (!port) {
    hasher = null;
    files.forEach((file) => file.lost());
    return hashed(null);
  }
  port.onmessage = ({ data }) => {
    if (data.choice !== choice) return;
    if (data.hashes) hashed(data.hashes);
    else files[data.number].back(data.buffer);
  };
}

/** Replaces the files to read; returns the number of this choice. */
export function choose(captures) {
  files.forEach((file) => file.close());
  choice++;
  hasher = offered;
  hashed(null);
  hasher?.postMessage({ choice, captures });
  const fair = MOST / PIECES / Math.max(1, captures.length);
  const length = Math.min(LONGEST, Math.max(SHORTEST, 2 ** Math.floor(Math.log2(fair))));
  files = captures.map((file, number) => new Chosen(file, number, length));
  return choice;
}

/** Whether other files have replaced the choice with this number. */
export const gone = (number) => number !== choice;

/** Whether another worker hashes the files. */
export const areHashed = () => hasher !== null;

/** Resolves when the decoder can go on. */
export const ready = () => Promise.all(files.map((file) => file.ready()));

/** Ends reading; the hashes of the files, null for an unreadable file; null without a hasher. */
export function hashes() {
  files.forEach((file) => file.close());
  hasher?.postMessage({ choice });
  return hasher ? new Promise((resolve) => (hashed = resolve)) : null;
}

/** Lends bytes in place of the file with this number; without bytes, the loan ends. */
export function lend(number, bytes) {
  if (bytes) lent.set(number, bytes);
  else lent.delete(number);
}

/** Copies bytes of a file into a buffer; returns their number. */
export function read(number, at, buffer) {
  const part = lent.get(number)?.subarray(at, at + buffer.length) ?? files[number].part(at, buffer.length);
  buffer.set(part);
  return part.length;
}

/** Reads a piece of a file at once. */
const pieceOf = (file, at, length) => new Uint8Array(reader.readAsArrayBuffer(file.slice(at, at + length)));

/** A file that is read ahead. */
class Chosen {
  #pieces = [];
  /** The last piece that was needed before it was read ahead. */
  #missed = null;
  #free;
  #ended = false;
  #freed = () => {};
  /** A promise for the next piece, and the function that fulfils it. */
  #coming = null;
  #came = () => {};

  constructor(file, number, length) {
    Object.assign(this, { file, number, length });
    this.#free = Array.from({ length: PIECES }, () => new ArrayBuffer(length));
    // If reading ahead fails, the decoder reads the piece itself and gets the error.
    this.#fill().catch(() => {}).then(() => this.#end());
  }

  /** Reads the file to its end, as far as buffers are free. */
  async #fill() {
    const stream = this.file.stream().getReader({ mode: "byob" });
    try {
      for (let from = 0; from < this.file.size; ) {
        while (this.#free.length === 0 && !this.#ended) await new Promise((resolve) => (this.#freed = resolve));
        if (this.#ended) return;
        const bytes = await filled(this.#free.pop(), stream, this.file.size - from);
        if (this.#ended || bytes.length === 0) return;
        this.#pieces.push({ from, bytes });
        from += bytes.length;
        this.#tell();
      }
    } finally {
      stream.cancel().catch(() => {});
    }
  }

  /** Resolves when half of the pieces are read, or all that the file has: enough for a step of the decoder. */
  async ready() {
    while (!this.#ended && this.#pieces.length < PIECES / 2) {
      this.#coming ??= new Promise((resolve) => (this.#came = resolve));
      await this.#coming;
    }
  }

  part(at, length) {
    while (this.#pieces.length > 0 && at >= end(this.#pieces[0])) this.#done(this.#pieces.shift());
    let [piece] = this.#pieces;
    if (!piece || at < piece.from) {
      piece = this.#missed;
      if (!piece || at < piece.from || at >= end(piece)) piece = this.#missed = { from: at, bytes: pieceOf(this.file, at, this.length) };
    }
    return piece.bytes.subarray(at - piece.from, at - piece.from + length);
  }

  /** Passes a piece to the hasher, which then need not read it a second time. */
  #done({ from, bytes }) {
    if (hasher) hasher.postMessage({ choice, number: this.number, from, bytes }, [bytes.buffer]);
    else this.back(bytes.buffer);
  }

  /** Takes a buffer back. */
  back(buffer) {
    this.#free.push(buffer);
    this.#freed();
  }

  /** Replaces the buffers that the hasher will not return. */
  lost() {
    for (let more = this.#free.length + this.#pieces.length + 1; more < PIECES; more++) this.back(new ArrayBuffer(this.length));
  }

  #end() {
    this.#ended = true;
    this.#freed();
    this.#tell();
  }

  #tell() {
    this.#coming = null;
    this.#came();
  }

  /** Ends reading of this file. */
  close() {
    this.#end();
    this.#pieces.splice(0).forEach((piece) => this.#done(piece));
    this.#missed = null;
  }
}

const end = ({ from, bytes }) => from + bytes.length;

/** Fills a buffer from a stream that has `left` bytes left. */
async function filled(buffer, stream, left) {
  const most = Math.min(buffer.byteLength, left);
  for (let length = 0; ; ) {
    // Each read returns a new view of the buffer for the rest.
    const { value, done } = await stream.read(new Uint8Array(buffer, length, most - length));
    buffer = value.buffer;
    length += value.length;
    if (done || length === most) return new Uint8Array(buffer, 0, length);
  }
}
