// Limbs: tapered rods with round ends, drawn in one call for each body.

const COARSE = [10, 2]; // corners around a rod, and rings per round end
const FINE = [16, 4];

const ROD_VERTEX = `precision highp float;
in vec3 position; // on a unit sphere with its axis along z
in vec3 from;
in vec3 to;
in vec3 across; // unit vector perpendicular to the axis
in vec3 axis; // unit vector
in vec2 radii;
in vec3 side;
in vec3 light;
uniform mat4 modelMatrix;
uniform mat4 viewMatrix;
uniform mat4 projectionMatrix;
out vec3 place;
out vec3 normal;
out vec3 sideTone;
out vec3 lightTone;

void main() {
  normal = position.x * across + position.y * cross(axis, across) + position.z * axis;
  bool far = position.z > 0.0;
  place = (far ? to : from) + (far ? radii.y : radii.x) * normal + modelMatrix[3].xyz;
  sideTone = side;
  lightTone = light;
  gl_Position = projectionMatrix * (viewMatrix * vec4(place, 1.0));
}
`;

const ROD_FRAGMENT = `precision highp float;
in vec3 place;
in vec3 normal;
in vec3 sideTone;
in vec3 lightTone;
out vec4 colour;
${LIT}
void main() {
  colour = vec4(lit(sideTone, lightTone, normalize(normal), place), 1.0);
}
`;

/**
 * Return points and triangles of a rod whose ends the shader moves apart.
 * @param {number} around corners around the rod
 * @param {number} each rings per round end
 */
function rodShape(around, each) {
  const points = [];
  const rings = 2 * each + 2;
  for (let ring = 0; ring < rings; ring++) {
    const far = ring > each;
    const step = far ? ring - each - 1 : ring - each;
    // Rings at the equators are displaced slightly, which shows their end to the shader.
    const angle = (step / each) * (Math.PI / 2) + (step ? 0 : far ? 1e-4 : -1e-4);
    for (let i = 0; i < around; i++) {
      const turn = (2 * Math.PI * i) / around;
      const wide = Math.cos(angle);
      points.push(wide * Math.cos(turn), wide * Math.sin(turn), Math.sin(angle));
    }
  }
  const index = [];
  for (let ring = 0; ring + 1 < rings; ring++)
    for (let i = 0; i < around; i++) {
      const [one, next] = [ring * around + i, ring * around + ((i + 1) % around)];
      index.push(one, next, next + around, one, next + around, one + around);
    }
  return [new Float32Array(points), index];
}

class Rods {
  /**
   * @param {[number, number, number, number, string][]} limbs ends, radii, m, and role
   * @param {Shades} shades
   */
  constructor(limbs, shades) {
    this.limbs = limbs;
    const count = limbs.length;
    const geometry = new THREE.InstancedBufferGeometry();
    for (const [name, size] of [["from", 3], ["to", 3], ["across", 3], ["axis", 3], ["radii", 2], ["side", 3], ["light", 3]])
      geometry.setAttribute(name, instanced(count, size));
    geometry.instanceCount = count;
    limbs.forEach(([, , one, other], i) => geometry.attributes.radii.setXY(i, one, other));
    this._shape(geometry, COARSE);
    this.mesh = new THREE.Mesh(geometry, material(ROD_VERTEX, ROD_FRAGMENT, shades.uniforms));
    this.caster = castingMaterial(ROD_VERTEX, shades.uniforms);
  }

  /** Make the rods rounder; call it before the first picture. */
  refine() {
    this._shape(this.mesh.geometry, FINE);
  }

  /** @param {object} geometry @param {number[]} detail */
  _shape(geometry, detail) {
    const [points, index] = rodShape(...detail);
    geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
    geometry.setIndex(index);
  }

  /** @param {object} tones see `tonesOf` */
  paint(tones) {
    const { side, light } = this.mesh.geometry.attributes;
    this.limbs.forEach(([, , , , role], i) => {
      side.array.set(tones[role][0], 3 * i);
      light.array.set(tones[role][1], 3 * i);
    });
    side.needsUpdate = light.needsUpdate = true;
  }

  /** @param {Pose} pose */
  show({ points }) {
    const { from, to, across, axis } = this.mesh.geometry.attributes;
    this.limbs.forEach(([one, other], i) => {
      const at = 3 * i;
      for (let j = 0; j < 3; j++) {
        from.array[at + j] = points[3 * one + j];
        to.array[at + j] = points[3 * other + j];
      }
      const along = [0, 1, 2].map((j) => points[3 * other + j] - points[3 * one + j]);
      const length = Math.hypot(...along);
      const [x, y, z] = length > 1e-9 ? along.map((value) => value / length) : [0, 0, 1];
      axis.setXYZ(i, x, y, z);
      // Perpendicular to the axis and to z or x, whichever is farther from the axis.
      const [u, v, w] = Math.abs(z) < 0.9 ? [y, -x, 0] : [0, z, -y];
      const wide = Math.hypot(u, v, w);
      across.setXYZ(i, u / wide, v / wide, w / wide);
    });
    from.needsUpdate = to.needsUpdate = across.needsUpdate = axis.needsUpdate = true;
  }
}
