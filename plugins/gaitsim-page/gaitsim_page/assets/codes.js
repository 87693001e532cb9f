// Challenge codes, as gaitsim/sharing writes and reads them. Nothing in a code is ever run.

const PREFIX = "gaitsim1-";
const LONGEST = 100_000; // characters; a code of a spider has about 500

/** @param {string} text base64, also its variant for URLs */
const bytesOf = (text) =>
  Uint8Array.from(atob(text.replaceAll("-", "+").replaceAll("_", "/")), (one) => one.charCodeAt(0));

const hexOf = (bytes) => Array.from(bytes, (one) => one.toString(16).padStart(2, "0")).join("");

/** @param {ArrayBufferView[]} arrays @returns {Uint8Array} their bytes */
function joined(arrays) {
  const parts = arrays.map((one) => new Uint8Array(one.buffer, one.byteOffset, one.byteLength));
  const all = new Uint8Array(parts.reduce((size, one) => size + one.length, 0));
  let place = 0;
  for (const part of parts) {
    all.set(part, place);
    place += part.length;
  }
  return all;
}

/** Decompress raw deflate data of at most 10 MB. @param {Uint8Array} bytes */
async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  const parts = [];
  const reader = stream.getReader();
  for (let size = 0; ; ) {
    const { done, value } = await reader.read();
    if (done) return joined(parts);
    parts.push(value);
    size += value.length;
    if (size > 1e7) throw new Error("too large");
  }
}

/** The hash SHA-256 (FIPS 180-4); browsers offer theirs only to some pages. @param {Uint8Array} bytes */
function sha256(bytes) {
  const primes = [];
  for (let n = 2; primes.length < 64; n++) if (primes.every((prime) => n % prime)) primes.push(n);
  const fraction = (root) => ((root - Math.floor(root)) * 2 ** 32) | 0;
  const keys = primes.map((prime) => fraction(Math.cbrt(prime)));
  const hash = primes.slice(0, 8).map((prime) => fraction(Math.sqrt(prime)));
  const padded = new Uint8Array((bytes.length + 72) & ~63);
  padded.set(bytes);
  padded[bytes.length] = 128;
  const view = new DataView(padded.buffer);
  view.setBigUint64(padded.length - 8, BigInt(8 * bytes.length));
  const words = new Int32Array(64);
  const turned = (word, by) => (word >>> by) | (word << (32 - by));
  for (let block = 0; block < padded.length; block += 64) {
    for (let i = 0; i < 64; i++) {
      const [one, other] = [words[i - 15], words[i - 2]];
      words[i] = i < 16 ? view.getInt32(block + 4 * i)
        : words[i - 16] + (turned(one, 7) ^ turned(one, 18) ^ (one >>> 3)) +
          words[i - 7] + (turned(other, 17) ^ turned(other, 19) ^ (other >>> 10));
    }
    let [a, b, c, d, e, f, g, h] = hash;
    for (let i = 0; i < 64; i++) {
      const [chosen, most] = [(e & f) ^ (~e & g), (a & b) ^ (a & c) ^ (b & c)];
      const first = h + (turned(e, 6) ^ turned(e, 11) ^ turned(e, 25)) + chosen + keys[i] + words[i];
      const second = (turned(a, 2) ^ turned(a, 13) ^ turned(a, 22)) + most;
      [h, g, f, e, d, c, b, a] = [g, f, e, (d + first) | 0, c, b, a, (first + second) | 0];
    }
    [a, b, c, d, e, f, g, h].forEach((word, i) => (hash[i] = (hash[i] + word) | 0));
  }
  const found = new DataView(new ArrayBuffer(32));
  hash.forEach((word, i) => found.setInt32(4 * i, word));
  return new Uint8Array(found.buffer);
}

// Lengths and distances of repeats: the smallest of each symbol, and its extra bits (RFC 1951).
const steps = (count, every, first) => {
  const found = [];
  for (let symbol = 0, next = first; symbol < count; symbol++) {
    const extra = Math.max(0, Math.floor(symbol / every) - 1);
    found.push([next, extra]);
    next += 2 ** extra;
  }
  return found;
};
const [LENGTHS, DISTANCES] = [steps(28, 4, 3), steps(30, 2, 1)];

/** Compress bytes to one block of fixed codes, with repeats of the dictionary. @param {Uint8Array} bytes */
function deflate(bytes) {
  const all = joined([DICTIONARY, bytes]);
  const places = new Map(); // of three bytes
  const key = (at) => all[at] | (all[at + 1] << 8) | (all[at + 2] << 16);
  const note = (at) => places.set(key(at), [...(places.get(key(at)) ?? []).slice(-30), at]);
  for (let at = 0; at < DICTIONARY.length; at++) note(at);
  const bits = [1, 1, 0]; // the last block; fixed codes
  const low = (value, count) => {
    for (let i = 0; i < count; i++) bits.push((value >> i) & 1);
  };
  const high = (value, count) => {
    for (let i = count; i--; ) bits.push((value >> i) & 1);
  };
  const symbol = (value) => {
    if (value < 144) high(48 + value, 8);
    else if (value < 256) high(256 + value, 9);
    else if (value < 280) high(value - 256, 7);
    else high(value - 88, 8);
  };
  for (let at = DICTIONARY.length; at < all.length; ) {
    let [length, from] = [2, 0];
    for (const place of places.get(key(at)) ?? []) {
      let same = 0;
      while (same < 257 && at + same < all.length && all[place + same] === all[at + same]) same++;
      if (same > length && at - place <= 32768) [length, from] = [same, place];
    }
    if (from || length > 2) {
      for (const [table, value, write] of [
        [LENGTHS, length, (one) => symbol(257 + one)],
        [DISTANCES, at - from, (one) => high(one, 5)],
      ]) {
        const one = table.findLastIndex(([first]) => first <= value);
        write(one);
        low(value - table[one][0], table[one][1]);
      }
    } else {
      symbol(all[at]);
      length = 1;
    }
    for (const end = at + length; at < end; at++) note(at);
  }
  symbol(256);
  const packed = new Uint8Array(Math.ceil(bits.length / 8));
  bits.forEach((bit, i) => (packed[i >> 3] |= bit << (i & 7)));
  return packed;
}

/**
 * Return the challenge code of a gait.
 * @param {{generation: number, score: number, text: string, genome: Float64Array}} gait
 */
function codeOf({ generation, score, text, genome }) {
  const [experiment, versions] = [text, DATA.versions].map((one) => new TextEncoder().encode(one));
  const head = new DataView(new ArrayBuffer(29));
  head.setUint32(0, generation, true);
  head.setFloat64(8, score, true);
  head.setUint8(16, "f".charCodeAt(0));
  [genome, experiment, versions].forEach((one, i) => head.setUint32(17 + 4 * i, one.length, true));
  const bytes = new Uint8Array(genome.buffer, genome.byteOffset, genome.byteLength);
  const planes = bytes.map((_, i) => bytes[8 * (i % genome.length) + Math.floor(i / genome.length)]);
  const packed = deflate(joined([head, experiment, versions, planes]));
  const whole = joined([new Uint8Array(4), packed]);
  new DataView(whole.buffer).setUint32(0, packed.length + 10);
  const data = joined([whole, sha256(whole).subarray(0, 6)]);
  const base = btoa(String.fromCharCode(...data));
  return PREFIX + base.replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

/**
 * Read the first code in a text.
 * @param {string} text
 * @returns {Promise<{generation: number, score: number, text: string, genome: Float64Array}>}
 * @throws {Error} the text is not the code of a gait that the page can play
 */
async function readCode(text) {
  const found = text.slice(0, 2 * LONGEST).replace(/[\s\p{Cf}>|]/gu, "").match(/gaitsim1-([\w-]+)/);
  if (!found) throw new Error("no code");
  const length = new DataView(bytesOf(found[1].slice(0, 8)).buffer).getUint32(0);
  const data = bytesOf(found[1].slice(0, Math.ceil((4 * length) / 3)));
  const [body, check] = [data.subarray(0, length - 6), data.subarray(length - 6)];
  if (data.length !== length || hexOf(sha256(body).subarray(0, 6)) !== hexOf(check))
    throw new Error("damaged");
  // A stored block in front of the content is its dictionary.
  const { length: size } = DICTIONARY;
  const stored = Uint8Array.of(0, size & 255, size >> 8, ~size & 255, (~size >> 8) & 255);
  const content = (await inflate(joined([stored, DICTIONARY, body.subarray(4)]))).subarray(size);
  const head = new DataView(content.buffer, content.byteOffset);
  const [genes, ...lengths] = [17, 21, 25].map((at) => head.getUint32(at, true));
  const [middle, end] = [29 + lengths[0], 29 + lengths[0] + lengths[1]];
  if (head.getUint8(16) !== "f".charCodeAt(0) || content.length !== end + 8 * genes)
    throw new Error("invalid");
  const bytes = Uint8Array.from({ length: 8 * genes }, (_, i) => content[end + (i >> 3) + genes * (i & 7)]);
  return {
    generation: head.getUint32(0, true),
    score: head.getFloat64(8, true),
    text: new TextDecoder().decode(content.subarray(29, middle)),
    genome: new Float64Array(bytes.buffer),
  };
}
