// Unpacking of arrays and JSON packed by packing.py.

/**
 * @typedef {{shape: number[], step: number, data: string}} Packed
 * @typedef {{shape: number[], values: Float64Array}} Numbers
 */

/**
 * Decode a base64 text.
 * @param {string} text
 * @returns {Uint8Array}
 */
function bytesOf(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
}

/**
 * Decompress raw deflate data.
 * @param {Uint8Array} bytes
 * @returns {Promise<Uint8Array>}
 */
async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/**
 * Unpack numbers, stored as byte planes of int32 differences along the first axis, in steps.
 * @param {Packed} packed
 * @returns {Promise<Numbers>} shape and values, row by row
 */
async function unpack(packed) {
  const { shape, step } = packed;
  const count = shape.reduce((product, length) => product * length, 1);
  const bytes = await inflate(bytesOf(packed.data));
  if (bytes.length !== 4 * count) throw new Error("The page's data is damaged.");
  const across = shape[0] ? count / shape[0] : 0;
  const values = new Float64Array(count);
  const sums = new Int32Array(across);
  for (let i = 0; i < count; i++) {
    const difference =
      bytes[i] |
      (bytes[count + i] << 8) |
      (bytes[2 * count + i] << 16) |
      (bytes[3 * count + i] << 24);
    values[i] = step * (sums[i % across] += difference);
  }
  return { shape, values };
}

/**
 * Unpack JSON.
 * @param {string} packed
 * @returns {Promise<any>}
 */
async function unpackJson(packed) {
  return JSON.parse(new TextDecoder().decode(await inflate(bytesOf(packed))));
}
