// A camera that turns around a point and follows it, moved by mouse, touch and keys.

// Azimuth and elevation as seen from the body, degrees. At −90° the camera is on the body's right,
// so forward points to the right of the picture.
const VIEWS = { iso: [-58, 27], side: [-90, 7], top: [-90, 89.9] };
const FIELD = 26; // vertical field of view, degrees
const CLOSEST = 0.15; // limits of the zoom, 1 fits the picture
const FARTHEST = 40;
const TURN = 0.35; // degrees per pixel

/**
 * Return the right, up and ahead axes of a camera, unit vectors.
 * @param {number} azimuth degrees
 * @param {number} elevation degrees
 */
function axesOf(azimuth, elevation) {
  const [a, e] = [azimuth, elevation].map((angle) => (angle * Math.PI) / 180);
  const [ca, sa, ce, se] = [Math.cos(a), Math.sin(a), Math.cos(e), Math.sin(e)];
  return [
    [-sa, ca, 0],
    [-se * ca, -se * sa, ce],
    [-ce * ca, -ce * sa, -se],
  ];
}

class Orbit {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {() => void} changed
   */
  constructor(canvas, changed) {
    this.camera = new THREE.PerspectiveCamera(FIELD, 1, 0.01, 100);
    this.camera.up.set(0, 0, 1);
    this.canvas = canvas;
    this.changed = changed;
    this.size = [1, 1];
    this.box = new Box().add(0, 0, 0, 0.5);
    this.target = [0, 0, 0];
    this.room = 0; // pixels covered at the lower edge
    /** @type {Map<number, {x: number, y: number}>} */
    this.fingers = new Map();
    this.view("iso");
    this._listen();
  }

  /**
   * Show a view, without zoom and shift.
   * @param {keyof VIEWS} name
   */
  view(name) {
    [this.azimuth, this.elevation] = VIEWS[name];
    this.name = name;
    this.zoom = 1;
    this.pan = [0, 0, 0];
    this.fit();
  }

  /**
   * Choose the distance at which a box around the target fits the picture.
   * @param {Box} box
   */
  fit(box = this.box) {
    this.box = box;
    const [right, up] = this.axes();
    const spans = [right, up].map((axis) =>
      axis.reduce((sum, share, i) => sum + Math.abs(share) * box.size[i], 1e-6),
    );
    const [width, height] = this.size;
    const wide = width < height ? 0.86 : 0.66;
    const scale = Math.min((wide * width) / spans[0], (0.62 * height) / spans[1]);
    this.distance = height / (2 * Math.tan((FIELD * Math.PI) / 360) * scale);
    this.changed();
  }

  /** Return the right, up and ahead axes of the camera, unit vectors. */
  axes() {
    return axesOf(this.azimuth, this.elevation);
  }

  /** Point at which the camera looks, m. */
  get aim() {
    const { middle } = this.box;
    return this.target.map((value, axis) => value + middle[axis] + this.pan[axis]);
  }

  /** Distance of the camera from that point, m. */
  get away() {
    return this.distance / this.zoom;
  }

  /** Pixels per metre at that point. */
  get scale() {
    return this.size[1] / (2 * Math.tan((FIELD * Math.PI) / 360) * this.away);
  }

  /**
   * Move the camera to its position.
   * @param {number} reach radius of the drawn ground, m
   */
  place(reach) {
    const { camera, away } = this;
    const [right, up, ahead] = this.axes();
    const aim = this.aim;
    camera.position.fromArray(aim.map((value, axis) => value - away * ahead[axis]));
    camera.up.fromArray(up);
    camera.lookAt(...aim);
    camera.aspect = this.size[0] / this.size[1];
    camera.near = 0.02 * away;
    camera.far = 4 * away + 3 * reach;
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
    return right;
  }

  /**
   * Turn around the target.
   * @param {number} across degrees
   * @param {number} above degrees
   */
  turn(across, above) {
    this.azimuth += across;
    this.elevation = clamp(this.elevation + above, -20, 89.9);
    this.changed();
  }

  /** @param {number} factor */
  magnify(factor) {
    this.zoom = clamp(this.zoom * factor, CLOSEST, FARTHEST);
    this.changed();
  }

  /**
   * Shift the view, as if the picture were dragged.
   * @param {number} x pixels to the right
   * @param {number} y pixels downwards
   */
  drag(x, y) {
    const [right, up] = this.axes();
    this.pan = this.pan.map((value, axis) => value + (y * up[axis] - x * right[axis]) / this.scale);
    this.changed();
  }

  _listen() {
    const { canvas, fingers } = this;
    const on = (name, listener) => canvas.addEventListener(name, listener, { passive: false });
    on("pointerdown", (event) => {
      fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      canvas.setPointerCapture(event.pointerId);
      canvas.classList.add("held");
    });
    on("pointermove", (event) => this._moved(event));
    for (const name of ["pointerup", "pointercancel"])
      on(name, (event) => {
        fingers.delete(event.pointerId);
        if (!fingers.size) canvas.classList.remove("held");
      });
    on("contextmenu", (event) => event.preventDefault());
    on("dblclick", () => this.view(this.name));
    on("wheel", (event) => {
      event.preventDefault();
      const lines = event.deltaMode === 1 ? 16 : 1;
      this.magnify(Math.exp(-0.0015 * clamp(event.deltaY * lines, -240, 240)));
    });
    on("keydown", (event) => this._pressed(event));
  }

  /** @param {PointerEvent} event */
  _moved(event) {
    const finger = this.fingers.get(event.pointerId);
    if (!finger) return;
    const { clientX: x, clientY: y } = event;
    const before = { ...finger };
    Object.assign(finger, { x, y });
    if (this.fingers.size === 1) {
      if (event.shiftKey || event.buttons & 6) this.drag(x - before.x, y - before.y);
      else this.turn(-TURN * (x - before.x), TURN * (y - before.y));
      return;
    }
    const other = [...this.fingers].find(([id]) => id !== event.pointerId)[1];
    const apart = (one) => Math.hypot(one.x - other.x, one.y - other.y);
    this.magnify(apart(finger) / Math.max(apart(before), 1));
    this.drag((x - before.x) / 2, (y - before.y) / 2);
  }

  /** @param {KeyboardEvent} event */
  _pressed(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    const way = step[event.key];
    if (!way) return;
    event.preventDefault();
    event.stopPropagation();
    if (event.shiftKey) this.drag(-24 * way[0], 24 * way[1]);
    else this.turn(6 * way[0], 6 * way[1]);
  }
}
