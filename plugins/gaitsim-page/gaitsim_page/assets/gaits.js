// Joint angles of the gaits of an archive, in the form stored by gaits.py.

class Gaits {
  /**
   * @param {object} data
   * @returns {Promise<Gaits>}
   */
  static async read(data) {
    const names = ["amounts", "waves", "periods", "lengths", "counts"].filter((name) => data[name]);
    const found = await Promise.all(names.map((name) => gaitsim.unpack(data[name])));
    const arrays = Object.fromEntries(names.map((name, i) => [name, found[i].values]));
    return new Gaits(data, arrays);
  }

  constructor(data, { amounts, waves, periods, lengths, counts }) {
    /** Number of joints of each gait; null if all have those of one body. */
    this.counts = counts ?? null;
    this.shared = data.joints?.length;
    this.rate = data.frameRate;
    this.exact = data.form === "waves";
    this.lowest = data.lowest;
    Object.assign(this, { amounts, waves, periods });
    if (this.exact) {
      this.frames = data.frames;
      this.count = waves.length / data.frames;
    } else {
      this.lengths = lengths;
      this.starts = [0];
      lengths.forEach((length, member) =>
        this.starts.push(this.starts.at(-1) + length * this.jointsOf(member)),
      );
    }
    this.held = { member: -1, stride: new Float64Array(0) };
  }

  /** @param {number} member counted from 0 @returns {number} */
  jointsOf(member) {
    return this.counts ? this.counts[member] : this.shared;
  }

  /** @param {number} member counted from 0 @returns {number} time until the gait repeats, s */
  seconds(member) {
    return (this.exact ? this.frames : this.periods[member]) / this.rate;
  }

  /** @param {number} member counted from 0 @returns {boolean} whether the gait repeats */
  repeats(member) {
    return this.exact || this.periods[member] < this.lengths[member] - 0.5;
  }

  /** @param {number} member counted from 0 @returns {number} number of stored frames */
  framesOf(member) {
    return this.exact ? this.frames : this.lengths[member];
  }

  /**
   * Return the joint angles of a gait at a time, interpolated between frames.
   * @param {number} member counted from 0
   * @param {number} seconds
   * @returns {Float64Array} rad
   */
  at(member, seconds) {
    const place = seconds * this.rate;
    const last = this.framesOf(member) - 1;
    const before = Math.min(Math.floor(place + 1e-9), last);
    const share = Math.max(place - before, 0);
    const angles = this.atFrame(member, before);
    if (before === last || share < 1e-9) return angles;
    const after = this.atFrame(member, before + 1);
    return angles.map((angle, joint) => angle + Math.min(share, 1) * (after[joint] - angle));
  }

  /**
   * @param {number} member counted from 0
   * @param {number} frame
   * @returns {Float64Array} joint angles, rad
   */
  atFrame(member, frame) {
    const joints = this.jointsOf(member);
    const angles = new Float64Array(joints);
    if (!this.exact) {
      const stride = this._stride(member);
      const length = this.lengths[member];
      return angles.map((_, joint) => stride[joint * length + frame]);
    }
    const { amounts, waves, count, frames, lowest } = this;
    let at = member * joints * count;
    for (let joint = 0; joint < joints; joint++)
      for (let wave = 0; wave < count; wave++)
        angles[joint] += (amounts[at++] + lowest) * waves[wave * frames + frame];
    return angles;
  }

  /** Return the joint angles of a stride, by summing its changes from frame to frame. */
  _stride(member) {
    if (this.held.member === member) return this.held.stride;
    const length = this.lengths[member];
    const stride = this.amounts.slice(this.starts[member], this.starts[member + 1]);
    for (let i = 0; i < stride.length; i++) {
      stride[i] += this.lowest;
      if (i % length) stride[i] += stride[i - 1];
    }
    this.held = { member, stride };
    return stride;
  }
}
