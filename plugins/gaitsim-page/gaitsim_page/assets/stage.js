// The stage: a canvas with ground, light, camera and bodies, redrawn only when something changes.

const REACH = 0.75; // radius of the drawn ground, in diagonals of the picture
const REST = 250; // ms without changes after which the picture is redrawn at the highest resolution

class Stage {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {object} theme see gaitsim/render/scene/themes.py
   * @throws {Error} the browser has no WebGL 2
   */
  constructor(canvas, theme) {
    this.coarse = drawnByProcessor();
    const drawn = this.coarse ? document.createElement("canvas") : canvas;
    const context = contextOf(drawn);
    if (!context) throw new Error("no WebGL");
    this.canvas = canvas;
    this.drawn = drawn;
    this.readback = this.coarse ? new Readback(context, canvas) : null;
    this.renderer = new THREE.WebGLRenderer({ canvas: drawn, context });
    this.renderer.autoClear = false;
    this.renderer.debug.checkShaderErrors = false;
    this.scene = new THREE.Scene();
    this.scene.matrixWorldAutoUpdate = false;
    this.orbit = new Orbit(canvas, () => this.request());
    this.ground = new Ground(null, 0, null);
    this.grid = new Grid();
    this.scene.add(this.grid.mesh);
    this.resolution = new Resolution(this.coarse);
    /** @type {Map<Body, Shadow>} */
    this.bodies = new Map();
    /** @type {((seconds: number) => boolean) | null} moves the bodies; returns false at the end */
    this.step = null;
    /** @type {(() => void)[]} called after each picture */
    this.listeners = [];
    this.theme = theme;
    this.watcher = new ResizeObserver(() => this.resize());
    this.watcher.observe(canvas);
    drawn.addEventListener("webglcontextrestored", () => {
      for (const body of this.bodies.keys()) body.moved = true;
      this.request();
    });
    this.resize();
  }

  /** @param {object} theme */
  set theme(theme) {
    this._theme = theme;
    this.grid.colour = theme.grid;
    this._paintGround();
    for (const [body, shadow] of this.bodies) body.theme = shadow.theme = theme;
    this.request();
  }

  /** @param {Body} body */
  add(body) {
    const shadow = new Shadow(this._theme);
    this.bodies.set(body, shadow);
    if (!this.coarse) body.rods.refine();
    this.scene.add(body.group, shadow.mesh);
    this.resize();
  }

  /** @param {Body} body */
  remove(body) {
    const shadow = this.bodies.get(body);
    if (!shadow) return;
    this.scene.remove(body.group, shadow.mesh);
    shadow.dispose();
    body.dispose();
    this.bodies.delete(body);
    this.request();
  }

  /** @param {Ground} ground */
  setGround(ground) {
    this.ground = ground;
    this.surface?.geometry.dispose();
    if (this.surface) this.scene.remove(this.surface);
    this.surface = null;
    if (!ground.level) {
      this.surfaceColours = {
        haze: { value: new THREE.Vector3() },
        dark: { value: new THREE.Vector3() },
        centre: this.grid.uniforms.centre,
        reach: this.grid.uniforms.reach,
      };
      const paint = material(GROUND_VERTEX, GROUND_FRAGMENT, this.surfaceColours);
      paint.side = THREE.DoubleSide;
      this.surface = new THREE.Mesh(new THREE.BufferGeometry(), paint);
      this.surface.frustumCulled = false;
      this.surface.renderOrder = ORDER.surface;
      this.scene.add(this.surface);
    }
    this.seen = null;
    this._paintGround();
    this.request();
  }

  /**
   * Choose the visible triangles of the ground.
   * @param {ArrayLike<number>} middle
   * @param {number} reach m
   */
  _cut(middle, reach) {
    const [x, y, far] = this.seen ?? [0, 0, 0];
    const away = Math.hypot(x - middle[0], y - middle[1]);
    if (reach + away < far && far < 1.6 * reach) return;
    this.seen = [middle[0], middle[1], 1.25 * reach];
    this.surface.geometry.dispose();
    this.surface.geometry = this.ground.surface(middle, 1.25 * reach);
  }

  _paintGround() {
    if (!this.surface) return;
    this.surfaceColours.haze.value.fromArray(rgb(this._theme.ground));
    this.surfaceColours.dark.value.fromArray(rgb(this._theme.shadow));
  }

  /**
   * Look at a point.
   * @param {ArrayLike<number>} point m
   */
  lookAt(point) {
    this.orbit.target = [point[0], point[1], point[2]];
    this.request();
  }

  /**
   * Follow a moving point smoothly.
   * @param {ArrayLike<number>} point m
   * @param {number} seconds time since the last call
   */
  follow(point, seconds) {
    const share = 1 - Math.exp(-seconds / 0.25);
    const { target } = this.orbit;
    this.lookAt(target.map((value, axis) => value + share * (point[axis] - value)));
  }

  /**
   * Fit the picture to a box around the point at which the camera looks.
   * @param {Box} box m
   */
  frame(box) {
    this.orbit.fit(box);
  }

  /** @param {"iso" | "side" | "top"} name */
  view(name) {
    this.orbit.view(name);
  }

  /**
   * Start or stop an animation.
   * @param {((seconds: number) => boolean) | null} step function that moves the bodies, given the
   *   seconds since the last picture, and returns whether to continue; null stops the animation
   */
  animate(step) {
    this.step = step;
    this.last = null;
    this.resolution.rest();
    if (step) this.request();
  }

  /** Schedule a redraw. */
  request() {
    this.frameRequest ??= requestAnimationFrame((time) => this._next(time));
  }

  /** @param {number} time ms */
  _next(time) {
    this.frameRequest = null;
    this.again = this.readback?.busy ?? false;
    if (this.again) return;
    if (this.step) {
      const seconds = this.last === null ? 0 : (time - this.last) / 1000;
      this.last = time;
      this.resolution.adapt(seconds, this.orbit.size);
      if (this.step(Math.min(seconds, 0.25))) this.request();
      else this.step = null;
    }
    this.draw();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    const before = this.orbit.size;
    this.orbit.size = [width, height];
    if (before[0] !== width || before[1] !== height) this.orbit.fit();
    this.request();
  }

  /** @param {number} ratio pixels of the picture per pixel of the page */
  _sharpen(ratio) {
    const [width, height] = this.orbit.size.map((length) => Math.floor(length * ratio));
    if (this.drawn.width !== width || this.drawn.height !== height)
      this.renderer.setDrawingBufferSize(...this.orbit.size, ratio);
    const bodies = [...this.bodies.keys()];
    for (const ribbons of [this.grid, ...bodies.flatMap((body) => body.ribbons)])
      ribbons.resize(width, height, ratio);
  }

  /**
   * Draw immediately.
   * @param {boolean} rests whether nothing has moved for a while
   */
  draw(rests = false) {
    const { renderer, scene, orbit } = this;
    const { camera } = orbit;
    if (this.readback?.busy) {
      this.again = true;
      return;
    }
    clearTimeout(this.resting);
    const finest = this.resolution.finest(orbit.size);
    const ratio = rests ? finest : Math.min(this.resolution.ratio, finest);
    this._sharpen(ratio);
    if (!this.step && ratio < finest) this.resting = setTimeout(() => this.draw(true), REST);
    const [middle, reach] = this._drawnGround();
    orbit.place(reach);
    this.grid.show(this.ground, middle, this._scaleAt(middle), reach);
    if (this.surface) this._cut(middle, reach);
    scene.updateMatrixWorld();
    renderer.setClearColor(0, 0);
    for (const [body, shadow] of this.bodies) {
      const { depths } = body.shades.uniforms;
      depths.value.x = Math.hypot(
        ...body.box.middle.map((value, axis) => camera.position.getComponent(axis) - value),
      );
      body.ribbons.forEach((ribbons) => ribbons.fade(middle, reach));
      if (body.moved) shadow.update(renderer, scene, body, this.ground);
      body.moved = false;
    }
    renderer.setClearColor(parseInt(this._theme.ground.slice(1), 16), 1);
    renderer.clear();
    renderer.render(scene, camera);
    if (this.readback) this.readback.take(this.drawn.width, this.drawn.height, () => this._shown());
    else this._shown();
  }

  /** Call the listeners after a picture is on the page. */
  _shown() {
    if (this.again) this.request();
    this.again = false;
    this.listeners.forEach((listener) => listener());
  }

  /** Return the middle and the radius of the drawn ground, m. */
  _drawnGround() {
    const { orbit } = this;
    const { aim, away, size } = orbit;
    const ahead = orbit.axes()[2];
    const foot = [aim[0], aim[1], this.ground.height(aim[0], aim[1])];
    // Below the body, or in the view of the camera if the body flies high.
    const above = Math.max(aim[2] - foot[2] - Math.max(...orbit.box.size), 0);
    const far = ahead[2] < -1e-3 ? Math.min(above / -ahead[2], 4 * away) : 0;
    foot[0] += ahead[0] * far;
    foot[1] += ahead[1] * far;
    return [foot, (REACH * Math.hypot(...size)) / this._scaleAt(foot)];
  }

  /** @param {ArrayLike<number>} point @returns {number} pixels of the page per metre at a point */
  _scaleAt(point) {
    const { orbit } = this;
    const ahead = orbit.axes()[2];
    const { aim, away } = orbit;
    const depth = ahead.reduce((sum, share, axis) => sum + share * (point[axis] - aim[axis]), away);
    return (orbit.scale * away) / Math.max(depth, 0.15 * away);
  }

  /** Distance between the finest visible lines of the grid, m. */
  get gridStep() {
    const [middle] = this._drawnGround();
    return gridSteps((1.5 * DENSE) / this._scaleAt(middle))[0];
  }

  /** Free the resources of the stage. */
  dispose() {
    cancelAnimationFrame(this.frameRequest);
    clearTimeout(this.resting);
    this.watcher.disconnect();
    this.renderer.dispose();
  }
}
