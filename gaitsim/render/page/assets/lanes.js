// Several bodies side by side on one ground, as gaitsim/render/scene/race.py has them.

const APART = 0.3; // between bodies side by side, in their widths
const STEEP = 0.7; // between lanes at least, in heights of a body
const WIDEST = 3; // of a lane, in widths of a body: a body that drifts farther crosses into another

/**
 * Return how far to the left each body is moved, the first the farthest, m.
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
      spanned(box, recording.clip, pose, BLACK);
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
