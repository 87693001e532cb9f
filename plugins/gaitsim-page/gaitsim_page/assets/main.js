// The viewer's only global, `gaitsim`, which scripts of other kinds of pages use:
//
//   gaitsim.register(kind, (data, root) => …)   add a kind of page; `start` calls the function
//   gaitsim.start(kind, data, root)             build a page in an element; called by boot.js
//   await gaitsim.unpack(packed)                {shape, values: Float64Array}, see packing.py
//   await gaitsim.unpackJson(packed)            the value, see packing.py
//   new gaitsim.Stage(canvas, theme)            throws without WebGL 2; .add(body), .remove(body),
//     .setGround(ground), .theme = theme, .frame(box) fits the picture, .view("iso" | "side" | "top"),
//     .lookAt(point), .follow(point, seconds) smoothly, .request() draws once,
//     .animate((seconds) => boolean) draws until the function returns false, .listeners are called
//     after each picture
//   new gaitsim.Body(clip, theme, lane, number, ground)   clip: limbs, plates, hulls, solids, feet, flies,
//     floor (its frames are not read); .show({points, poses, feet, touching, centre}) moves the body,
//     .trail(centre, frame) draws its path, .box is its bounding box
//   await gaitsim.Recording.read(clip)          .at(seconds) is a pose for Body.show, with `aim` for
//     Stage.lookAt; .box is for Stage.frame; .seconds, .ground, .anglesAt(frame)
//   new gaitsim.Ground(null, floor, null)       level ground
//   new gaitsim.Box().add(x, y, z, radius)      a box that grows around points
//   gaitsim.Themes, Announcer, Controls, Clock, element, drawing, numeral, secondsText,
//     withoutPicture, listenToKeys, speedBeside, nextView: parts of pages, described in their files
//
// `theme` is data.theme.light or data.theme.dark.

/** @type {Map<string, (data: any, root: HTMLElement) => any>} */
const kinds = new Map();

/**
 * Build a page in an element.
 * @param {string} kind
 * @param {any} data
 * @param {HTMLElement} root
 */
async function start(kind, data, root) {
  const build = kinds.get(kind);
  if (!build) throw new Error(`unknown kind of page: ${kind}`);
  return build(data, root);
}

kinds.set("player", async (data, root) => {
  const recordings = await Promise.all(data.clips.map((clip) => Recording.read(clip)));
  return new Player(data, recordings, root);
});

globalThis.gaitsim = Object.freeze({
  THREE,
  register: (kind, build) => void kinds.set(kind, build),
  start,
  unpack,
  unpackJson,
  rgb,
  clamp,
  numeral,
  secondsText,
  element,
  drawing,
  listenToKeys,
  nextView,
  speedBeside,
  withoutPicture,
  Announcer,
  Body,
  Box,
  Clock,
  Controls,
  Ground,
  Recording,
  Stage,
  Themes,
});
