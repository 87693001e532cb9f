// The viewer's only global, `gaitsim`. What pages of other kinds build on:
//
//   gaitsim.register(kind, (data, root) => …)   a kind of page; `start` calls it with the page's data
//   gaitsim.start(kind, data, root)             build the page into an element; boot.js calls it
//   await gaitsim.unpack(packed)                {shape, values: Float64Array}, see packing.py
//   new gaitsim.Stage(canvas, theme)            throws where there is no WebGL 2; .add(body), .remove(body),
//     .setGround(ground), .theme = theme, .frame(box) fits the picture, .view("iso" | "side" | "top"),
//     .lookAt(point), .follow(point, seconds) smoothly, .request() draws once,
//     .animate((seconds) => boolean) draws until it returns false, .listeners after each picture
//   new gaitsim.Body(clip, theme, lane, number, ground)   clip: limbs, plates, hulls, solids, feet, flies,
//     floor (its frames are not read); .show({points, poses, feet, touching, centre}) moves it,
//     .trail(centre, frame) draws the path behind it, .box is where it is
//   await gaitsim.Recording.read(clip)          .at(seconds) is a pose for Body.show, with `aim` for
//     Stage.lookAt; .box for Stage.frame, .seconds, .ground, .anglesAt(frame)
//   new gaitsim.Ground(null, floor, null)       level ground
//   new gaitsim.Box().add(x, y, z, radius)      a box that grows around points
//   gaitsim.Themes, Announcer, Timeline, Controls, Clock, element, drawing, button, icon, numeral,
//     lengthText, secondsText, withoutPicture, listenToKeys, speedBeside, nextView, panelOf: parts of
//     the page, see their files
//
// `theme` is data.theme.light or data.theme.dark.

/** @type {Map<string, (data: any, root: HTMLElement) => any>} */
const kinds = new Map();

/**
 * Build a page into an element.
 * @param {string} kind
 * @param {any} data
 * @param {HTMLElement} root
 */
async function start(kind, data, root) {
  const build = kinds.get(kind);
  if (!build) throw new Error(`This viewer has no pages of the kind ${kind}.`);
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
  rgb,
  clamp,
  numeral,
  lengthText,
  secondsText,
  element,
  drawing,
  button,
  icon,
  listenToKeys,
  nextView,
  panelOf,
  speedBeside,
  withoutPicture,
  Announcer,
  Body,
  Box,
  Clock,
  Controls,
  Ground,
  Player,
  Recording,
  Ribbons,
  Stage,
  Themes,
  Timeline,
});
