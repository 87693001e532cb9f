// Several bodies side by side on one ground, in lanes like those of gaitsim/render/scene/clip.py.

const APART = 0.3; // gap between bodies side by side, in body widths
const STEEP = 0.7; // minimum distance of lanes, in body heights
const WIDEST = 3; // maximum width of a lane, in body widths; bodies that drift farther leave theirs

/**
 * Return the displacement of each body to the left, m; the first body is leftmost.
 * @param {Recording[]} recordings
 * @returns {number[]}
 */
function lanesOf(recordings) {
  if (recordings.length < 2) return recordings.map(() => 0);
  const wide = Math.max(...recordings.map(({ box }) => box.size[1]));
  const tall = Math.max(...recordings.map(({ box }) => box.size[2]));
  const seconds = Math.max(...recordings.map((one) => one.seconds));
  const edges = recordings.map((recording) =>
    Array.from({ length: 100 }, (_, i) => {
      const pose = recording.at((i * seconds) / 99);
      const box = new Box();
      extendBox(box, recording.clip, pose, BLACK);
      return [box.low[1], box.high[1]];
    }),
  );
  const lanes = [0];
  for (let i = 1; i < edges.length; i++) {
    const step =
      Math.max(...edges[i].map(([, left], j) => left - edges[i - 1][j][0])) + APART * wide;
    lanes.push(lanes[i - 1] - Math.max(Math.min(step, WIDEST * wide), STEEP * tall));
  }
  const middle = (lanes[0] + lanes.at(-1)) / 2;
  return lanes.map((lane) => lane - middle);
}
