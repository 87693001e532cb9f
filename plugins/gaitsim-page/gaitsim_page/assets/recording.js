// The motion of one individual: frames stored in the page, and poses between them.

/**
 * @typedef {object} Pose a body at one moment
 * @property {ArrayLike<number>} points (points, 3) m
 * @property {ArrayLike<number> | null} poses position and quaternion w x y z of solids, (solids, 7)
 * @property {ArrayLike<number> | null} feet (feet, 3) m
 * @property {ArrayLike<number> | null} touching whether each foot is on the ground, (feet,)
 * @property {ArrayLike<number>} centre (3,) m
 */

class Recording {
  /**
   * Read a clip of the page's data.
   * @param {object} clip see clips.py
   * @returns {Promise<Recording>}
   */
  static async read(clip) {
    const { feet, ground, angles } = clip;
    const [points, poses, centre, feetPoints, touching, heights, turns] = await Promise.all(
      [
        clip.points,
        clip.poses,
        clip.centre,
        feet?.points,
        feet?.touching,
        ground?.heights,
        angles?.values,
      ].map((packed) => (packed ? unpack(packed) : null)),
    );
    return new Recording(clip, {
      points: points.values,
      poses: poses?.values ?? null,
      centre: centre.values,
      feet: feetPoints?.values ?? null,
      touching: touching?.values ?? null,
      heights,
      angles: turns?.values ?? null,
    });
  }

  /**
   * @param {object} clip
   * @param {object} values unpacked
   */
  constructor(clip, values) {
    this.clip = clip;
    this.values = values;
    this.frameRate = clip.frameRate;
    this.frames = clip.frames;
    /** Time from the first frame to the last, s. */
    this.seconds = (clip.frames - 1) / clip.frameRate;
    this.feet = clip.feet ? clip.feet.names.length : 0;
    this.aims = smoothPath(values.centre, clip.frameRate);
    this.ground = new Ground(clip.ground, clip.floor, values.heights);
  }

  /**
   * Return the pose at a time, interpolated between frames; the last pose after the end.
   * @param {number} seconds
   * @returns {Pose & {aim: number[], frame: number}} pose with the aim of the camera
   */
  at(seconds) {
    const place = clamp(seconds * this.frameRate, 0, this.frames - 1);
    const frame = Math.min(Math.floor(place + 1e-6), this.frames - 1);
    const share = frame < this.frames - 1 ? Math.max(place - frame, 0) : 0;
    const { points, poses, centre, feet, touching } = this.values;
    return {
      frame,
      points: this._between(points, frame, share),
      poses: poses && this._posesBetween(poses, frame, share),
      feet: feet && this._between(feet, frame, share),
      touching: touching && this._touchingBetween(touching, frame, share),
      centre: this._between(centre, frame, share),
      aim: [...this._between(this.aims, frame, share)],
    };
  }

  /** Return which feet are on the ground; a foot that lands or lifts between frames is not. */
  _touchingBetween(touching, frame, share) {
    const row = (at) => touching.subarray(at * this.feet, (at + 1) * this.feet);
    if (share < 1e-6) return row(frame);
    const after = row(frame + 1);
    return row(frame).map((down, foot) => down && after[foot]);
  }

  /**
   * Return the joint angles of a frame, rad; null for a body without joints.
   * @param {number} frame
   */
  anglesAt(frame) {
    const { angles } = this.values;
    const joints = angles ? angles.length / this.frames : 0;
    return angles && angles.subarray(frame * joints, (frame + 1) * joints);
  }

  /** A box around the body relative to the aim of the camera, from up to 100 moments, m. */
  get box() {
    this._box ??= this._boxAbout((pose) => pose.aim);
    return this._box;
  }

  /** Return a box around the body at a time, relative to the aim of the camera, m. @param {number} seconds */
  boxAt(seconds) {
    const pose = this.at(seconds);
    const box = new Box();
    extendBox(box, this.clip, pose, pose.aim);
    return box;
  }

  /** A box around the whole motion, m. */
  get whole() {
    this._whole ??= this._boxAbout(() => BLACK);
    return this._whole;
  }

  /** @param {(pose: object) => ArrayLike<number>} origin */
  _boxAbout(origin) {
    const box = new Box();
    for (const seconds of this.moments()) {
      const pose = this.at(seconds);
      extendBox(box, this.clip, pose, origin(pose));
    }
    return box;
  }

  /** Return up to 100 times of the motion, s. */
  moments() {
    const count = Math.min(this.frames, 100);
    return Array.from({ length: count }, (_, i) => (i * this.seconds) / Math.max(count - 1, 1));
  }

  /** @param {Float64Array} values (frames, …) @param {number} frame @param {number} share */
  _between(values, frame, share) {
    const size = values.length / this.frames;
    const one = values.subarray(frame * size, (frame + 1) * size);
    if (!share) return one;
    const other = values.subarray((frame + 1) * size, (frame + 2) * size);
    return one.map((value, i) => value + share * (other[i] - value));
  }

  /** @param {Float64Array} values @param {number} frame @param {number} share */
  _posesBetween(values, frame, share) {
    if (!share) return this._between(values, frame, 0);
    const size = values.length / this.frames;
    const found = new Float64Array(size);
    for (let i = 0, at = frame * size; i < size; i += 7, at += 7) {
      let nearer = 0;
      for (let j = 3; j < 7; j++) nearer += values[at + j] * values[at + size + j];
      for (let j = 0; j < 7; j++) {
        const next = values[at + size + j] * (j > 2 && nearer < 0 ? -1 : 1);
        found[i + j] = values[at + j] + share * (next - values[at + j]);
      }
      const length = Math.hypot(found[i + 3], found[i + 4], found[i + 5], found[i + 6]) || 1;
      for (let j = 3; j < 7; j++) found[i + j] /= length;
    }
    return found;
  }
}

/**
 * Extend a box to contain a body in a pose, relative to an origin.
 * @param {Box} box
 * @param {object} clip
 * @param {Pose} pose
 * @param {ArrayLike<number>} origin
 */
function extendBox(box, clip, pose, origin) {
  const { points, poses } = pose;
  for (let i = 0; i < points.length; i += 3)
    box.add(points[i] - origin[0], points[i + 1] - origin[1], points[i + 2] - origin[2]);
  clip.solids.forEach((solid, i) => {
    const [x, y, z] = poses.subarray ? poses.subarray(7 * i, 7 * i + 3) : poses.slice(7 * i);
    box.add(x - origin[0], y - origin[1], z - origin[2], radiusOf(solid));
  });
}

/**
 * Return an approximate radius of a solid around its position, m.
 * @param {object} solid
 */
function radiusOf(solid) {
  const { shape, size, vertices } = solid;
  if (shape === "mesh") return 0.7 * Math.max(...vertices.map((point) => Math.hypot(...point)));
  if (shape === "capsule") return 0.7 * (size[0] + size[1]);
  return 0.7 * Math.hypot(...(shape === "sphere" ? [size[0]] : size));
}
