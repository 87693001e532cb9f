// One body on the stage: limbs, plates, hulls, solids, feet and the path behind it.

const FOOT = 1.55; // radius of a foot's mark, in the usual radius of limbs
const PATH = 400; // pieces of the path, at most
const THIN = 1.1; // pixels, of edges between faces
const WIDE = 2.4; // pixels, of the path

class Body {
  /**
   * @param {object} clip how it is drawn, see gaitsim/render/page/clips.py; of its frames nothing
   *   is read
   * @param {object} theme see gaitsim/render/scene/themes.py
   * @param {number} lane how far it is moved to the left, m
   * @param {number} number of the body among others, from 0, for its colour
   * @param {Ground | null} ground the clip's; None: level at its floor
   */
  constructor(clip, theme, lane = 0, number = 0, ground = null) {
    this.clip = clip;
    this.lane = lane;
    this.number = number;
    this.ground = ground ?? new Ground(null, clip.floor ?? 0, null);
    this.shades = new Shades(theme);
    this.box = new Box();
    /** Its greatest length, m; known from its first pose where the clip does not say it. */
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
   * Move it to a pose.
   * @param {Pose} pose points, poses, feet, touching and centre; what the clip does not have may be
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
    spanned(this.box, this.clip, pose, [0, -this.lane, 0]);
    this.span ||= Math.max(...this.box.size);
    this.shades.uniforms.depths.value.y = this.span;
  }

  /**
   * Draw the path to here.
   * @param {Float64Array} centre where it was in each frame, (frames, 3) m
   * @param {number} frame the last one to draw
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
   * Give all parts the materials of their shadow, or their own ones again.
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

  /** Free what it holds. */
  dispose() {
    this.group.traverse((mesh) => mesh.geometry?.dispose());
  }
}
