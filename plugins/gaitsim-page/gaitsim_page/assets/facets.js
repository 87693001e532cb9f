// Flat faces that move with the points of a body: plates, such as wings, and hulls, such as trunks.

const FACET_VERTEX = `precision highp float;
in vec3 position;
in vec3 side;
in vec3 light;
uniform mat4 modelMatrix;
uniform mat4 viewMatrix;
uniform mat4 projectionMatrix;
out vec3 place;
out vec3 sideTone;
out vec3 lightTone;

void main() {
  place = (modelMatrix * vec4(position, 1.0)).xyz;
  sideTone = side;
  lightTone = light;
  gl_Position = projectionMatrix * (viewMatrix * vec4(place, 1.0));
}
`;

const FACET_FRAGMENT = `precision highp float;
in vec3 place;
in vec3 sideTone;
in vec3 lightTone;
out vec4 colour;
${LIT}
void main() {
  vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
  normal *= sign(dot(normal, cameraPosition - place));
  colour = vec4(lit(sideTone, lightTone, normal, place), 1.0);
}
`;

class Facets {
  /**
   * @param {{corners: number[], half: number}[]} plates corners in order, and half the thickness, m
   * @param {number[][][]} hulls corners of the faces of each hull
   * @param {Shades} shades
   */
  constructor(plates, hulls, shades) {
    this.plates = plates;
    /** @type {[number, number, number, string][]} three corners and a role */
    this.triangles = hulls.flat().flatMap((face) => fan(face));
    this.sheets = plates.map(({ corners, half }) => ({ corners, half, fan: fan(corners) }));
    const sheets = this.sheets.reduce((sum, sheet) => sum + 2 * sheet.fan.length, 0);
    const count = 3 * (this.triangles.length + sheets);
    const geometry = new THREE.BufferGeometry();
    for (const name of ["position", "side", "light"])
      geometry.setAttribute(
        name,
        new THREE.BufferAttribute(new Float32Array(3 * count), 3).setUsage(THREE.DynamicDrawUsage),
      );
    const paint = material(FACET_VERTEX, FACET_FRAGMENT, shades.uniforms);
    paint.side = THREE.DoubleSide;
    this.mesh = new THREE.Mesh(geometry, paint);
    this.caster = castingMaterial(FACET_VERTEX, shades.uniforms);
    this.count = count;
  }

  /** Rounded edges of plates, as limbs. */
  get rims() {
    return this.plates.flatMap(({ corners, half }) =>
      corners.map((corner, i) => [corner, corners[(i + 1) % corners.length], half, half, "trunk"]),
    );
  }

  /** Edges between the faces of hulls, as pairs of points. */
  static edges(hulls) {
    const pairs = new Map();
    for (const face of hulls.flat())
      face.forEach((corner, i) => {
        const pair = [corner, face[(i + 1) % face.length]].sort((a, b) => a - b);
        pairs.set(pair.join(), pair);
      });
    return [...pairs.values()];
  }

  /** @param {object} tones see `tonesOf` */
  paint(tones) {
    const { side, light } = this.mesh.geometry.attributes;
    for (let i = 0; i < this.count; i++) {
      const role = i < 3 * this.triangles.length ? "limb" : "trunk";
      side.array.set(tones[role][0], 3 * i);
      light.array.set(tones[role][1], 3 * i);
    }
    side.needsUpdate = light.needsUpdate = true;
  }

  /** @param {Pose} pose */
  show({ points }) {
    const { position } = this.mesh.geometry.attributes;
    let at = 0;
    /** @param {number[]} triangle @param {number[]} shift */
    const put = (triangle, shift) => {
      for (const corner of triangle)
        for (let axis = 0; axis < 3; axis++)
          position.array[at++] = points[3 * corner + axis] + shift[axis];
    };
    for (const triangle of this.triangles) put(triangle, BLACK);
    for (const sheet of this.sheets) {
      const normal = normalOf(points, sheet.corners);
      for (const side of [1, -1]) {
        const shift = normal.map((value) => side * sheet.half * value);
        for (const triangle of sheet.fan) put(triangle, shift);
      }
    }
    position.needsUpdate = true;
  }
}

/** Return the triangles of a polygon. @param {number[]} corners */
function fan(corners) {
  return corners.slice(2).map((corner, i) => [corners[0], corners[i + 1], corner]);
}

/**
 * Return the unit normal of a polygon.
 * @param {ArrayLike<number>} points
 * @param {number[]} corners
 */
function normalOf(points, corners) {
  const normal = [0, 0, 0];
  const point = (corner) => [0, 1, 2].map((axis) => points[3 * corner + axis]);
  const origin = point(corners[0]);
  for (const [, one, other] of fan(corners)) {
    const a = point(one).map((value, axis) => value - origin[axis]);
    const b = point(other).map((value, axis) => value - origin[axis]);
    normal[0] += a[1] * b[2] - a[2] * b[1];
    normal[1] += a[2] * b[0] - a[0] * b[2];
    normal[2] += a[0] * b[1] - a[1] * b[0];
  }
  const length = Math.hypot(...normal) || 1;
  return normal.map((value) => value / length);
}
