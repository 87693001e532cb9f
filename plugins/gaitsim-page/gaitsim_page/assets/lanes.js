// Several bodies side by side on one ground, in lanes like those of gaitsim/render/scene/clip.py.

const APART = 0.3; // gap between bodies side by side, in body widths
const WIDEST = 3; // maximum width of a lane, in body widths; bodies that drift farther leave theirs

/**
 * Return the displacement of each body to the left, m; the first body is leftmost.
 *
 * At the start, the boxes of the bodies do not overlap in the picture either.
 * @param {Recording[]} recordings
 * @returns {number[]}
 */
function lanesOf(recordings) {
  if (recordings.length < 2) return recordings.map(() => 0);
  const wide = Math.max(...recordings.map(({ box }) => box.size[1]));
  const seconds = Math.max(...recordings.map((one) => one.seconds));
  const edges = recordings.map((recording) =>
    Array.from({ length: 100 }, (_, i) => {
      const pose = recording.at((i * seconds) / 99);
      const box = new Box();
      extendBox(box, recording.clip, pose, BLACK);
      return [box.low[1], box.high[1]];
    }),
  );
  const [right, up] = axesOf(...VIEWS.iso);
  const ahead = right[1] ** 2 + up[1] ** 2;
  // Extent of each body at the start along the lanes as they are in the picture.
  const extents = recordings.map((recording) => {
    const { size } = recording.boxAt(0);
    const share = (axis) => Math.abs(right[axis] * right[1] + up[axis] * up[1]) / ahead;
    return size.reduce((sum, length, axis) => sum + length * share(axis), 0);
  });
  const lanes = [0];
  for (let i = 1; i < edges.length; i++) {
    const step =
      Math.max(...edges[i].map(([, left], j) => left - edges[i - 1][j][0])) + APART * wide;
    const apart = (extents[i - 1] + extents[i]) / 2;
    lanes.push(lanes[i - 1] - Math.max(Math.min(step, WIDEST * wide), apart));
  }
  const middle = (lanes[0] + lanes.at(-1)) / 2;
  return lanes.map((lane) => lane - middle);
}
