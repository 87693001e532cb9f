// One body on the stage: limbs, plates, hulls, solids, feet and its path.

const FOOT = 1.55; // radius of a foot's mark, relative to the usual radius of limbs
const PATH = 400; // maximum pieces of the path
const THIN = 1.1; // width of edges between faces, pixels
const WIDE = 2.4; // width of the path, pixels

class Body {
  /**
   * @param {object} clip drawn shape, see clips.py; its frames are not read
   * @param {object} theme see gaitsim/render/scene/themes.py
   * @param {number} lane displacement to the left, m
   * @param {number} number index of the body, which selects its colour
   * @param {Ground | null} ground ground of the clip; null for level ground at its floor
   */
  constructor(clip, theme, lane = 0, number = 0, ground = null) {
    this.clip = clip;
    this.lane = lane;
    this.number = number;
    this.ground = ground ?? new Ground(null, clip.floor ?? 0, null);
    this.shades = new Shades(theme);
    this.box = new Box();
    /** Largest extent, m; taken from the first pose if the clip has none. */
    this.span = clip.span ?? 0;
    this.group = new THREE.Group();
    this.group.position.y = lane;
    const solid = clip.solids.length > 0;
    this.facets = new Facets(solid ? [] : clip.plates, solid ? [] : clip.hulls, this.shades);
    this.rods = new Rods(solid ? [] : [...clip.limbs, ...this.facets.rims], this.shades);
    this.solids = new Solids(clip.solids, this.shades);
    this.marks = clip.feet ? new Marks(clip.feet, this._markRadius(), this.shades) : null;
    this.edges = new Ribbons(THIN, { polygonOffset: true, polygonOffsetFactor: -1 });
    this.creases = solid ? [] : Facets.edges(clip.hulls);
    this.path = new Ribbons(WIDE, { depthTest: clip.flies });
    this.path.mesh.renderOrder = clip.flies ? ORDER.edges : ORDER.path;
    this.edges.mesh.renderOrder = ORDER.edges;
    this.behind = null;
    this.parts = [this.rods, this.facets].filter((part) => part.limbs?.length || part.count);
    const meshes = [...this.parts.map(({ mesh }) => mesh), ...this.solids.meshes];
    for (const mesh of meshes) {
      mesh.frustumCulled = false;
      mesh.renderOrder = ORDER.body;
    }
    this.group.add(...this.parts.map(({ mesh }) => mesh), this.solids.group, this.edges.mesh);
    this.group.add(this.path.mesh);
    if (this.marks) this.group.add(this.marks.mesh);
    if (this.marks) this.marks.mesh.frustumCulled = false;
    this.ribbons = [this.edges, this.path];
    this.theme = theme;
  }

  /** @param {object} theme */
  set theme(theme) {
    const tones = tonesOf(theme, this.number);
    this.shades.theme = theme;
    for (const part of [this.rods, this.facets, this.solids]) part.paint(tones);
    this.edges.colour = theme.limb_edge;
    this.path.colour = theme.bodies[this.number % theme.bodies.length];
    if (this.marks) this.marks.theme = theme;
    if (this.pose) this.show(this.pose);
  }

  _markRadius() {
    const { mark, limbs } = this.clip;
    const radii = limbs.filter((limb) => limb[4] !== "trunk").flatMap((limb) => [limb[2], limb[3]]);
    return mark ?? FOOT * Math.max(...radii, 1e-4);
  }

  /**
   * Move the body to a pose.
   * @param {Pose} pose points, poses, feet, touching and centre; parts that the clip lacks may be
   *   missing
   */
  show(pose) {
    this.pose = pose;
    this.moved = true;
    this.parts.forEach((part) => part.show(pose));
    if (this.clip.solids.length) this.solids.show(pose);
    if (this.marks && pose.feet) this.marks.show(pose, this.ground, this.lane);
    const { points } = pose;
    const ends = this.creases.flatMap(([one, other]) => [
      ...points.slice(3 * one, 3 * one + 3),
      ...points.slice(3 * other, 3 * other + 3),
    ]);
    this.edges.set(ends, this.creases.map(() => 0.8));
    this.box = new Box();
    extendBox(this.box, this.clip, pose, [0, -this.lane, 0]);
    this.span ||= Math.max(...this.box.size);
    this.shades.uniforms.depths.value.y = this.span;
  }

  /**
   * Draw the path up to a frame.
   * @param {Float64Array} centre position of the body in each frame, (frames, 3) m
   * @param {number} frame last frame to draw
   */
  trail(centre, frame) {
    const every = Math.max(1, Math.ceil(frame / PATH));
    const ends = [];
    const strengths = [];
    const at = (i) => {
      const [x, y, z] = i < frame ? centre.subarray(3 * i, 3 * i + 3) : (this.pose?.centre ?? []);
      return this.clip.flies ? [x, y, z] : [x, y, this.ground.height(x, y + this.lane)];
    };
    for (let i = 0; i < frame; i += every) {
      ends.push(...at(i), ...at(Math.min(i + every, frame)));
      strengths.push(0.9);
    }
    this.path.set(ends, strengths);
  }

  /**
   * Switch all parts between the materials of their shadow and their own.
   * @param {boolean} on
   */
  casting(on) {
    for (const part of this.parts) {
      part.own ??= part.mesh.material;
      part.mesh.material = on ? part.caster : part.own;
    }
    for (const mesh of this.solids.meshes) {
      mesh.userData.own ??= mesh.material;
      mesh.material = on ? this.solids.caster : mesh.userData.own;
    }
    for (const mesh of [...this.parts.map((part) => part.mesh), ...this.solids.meshes])
      if (on) mesh.layers.enable(CASTERS);
      else mesh.layers.disable(CASTERS);
  }

  /** Free the resources of the body. */
  dispose() {
    this.group.traverse((mesh) => mesh.geometry?.dispose());
  }
}
