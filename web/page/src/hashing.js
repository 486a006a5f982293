// Hashes captures while another worker reads them, from the pieces that this worker has read.
import { Hasher } from "canvass-wasm";

/** Number of bytes of a piece, for parts of files that the other worker has not read. */
const PIECE = 1 << 20;

let chosen = { choice: null, files: [] };

/**
 * Hashes captures for the worker at this port, which sends `captures`, then pieces, then a message without either.
 * Pieces are sent back for reuse, and the last message is answered with the hashes. `asked` is called for each choice of
 * captures.
 */
export function hashFor(port, asked) {
  port.onmessage = async ({ data: { choice, captures, number, from, bytes } }) => {
    if (captures) {
      asked();
      begin(choice, captures);
    } else if (choice !== chosen.choice) return;
    else if (bytes) {
      const file = chosen.files[number];
      // If earlier bytes are missing, they are read at the end, together with all bytes after them.
      if (file.at === from) take(file, bytes);
      port.postMessage({ choice, number, buffer: bytes.buffer }, [bytes.buffer]);
    } else {
      const hashes = await finished(choice);
      if (hashes) port.postMessage({ choice, hashes });
    }
  };
}

/** The hashes of the files of a choice; null if others were chosen meanwhile. */
async function finished(choice) {
  const hashes = [];
  for (const file of chosen.files) {
    hashes.push(await finish(file, () => choice === chosen.choice));
    if (choice !== chosen.choice) return null;
  }
  return hashes;
}

function begin(choice, captures) {
  chosen.files.forEach(({ hasher }) => hasher.free());
  chosen = { choice, files: captures.map((file) => ({ file, hasher: new Hasher(), at: 0 })) };
}

function take(file, bytes) {
  file.hasher.update(bytes);
  file.at += bytes.length;
}

/** The hash of a whole file; null if the file can't be read, or is not wanted any more. */
async function finish(one, isWanted) {
  const { file, hasher } = one;
  try {
    while (one.at < file.size) {
      const piece = new Uint8Array(await file.slice(one.at, one.at + PIECE).arrayBuffer());
      if (piece.length === 0 || !isWanted()) return null;
      take(one, piece);
    }
    return isWanted() ? hasher.digest() : null;
  } catch {
    return null;
  }
}
