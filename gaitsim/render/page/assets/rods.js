// Limbs: tapered rods with round ends, all of a body in one draw.

const AROUND = 14;
const RINGS = 4; // of each round end

const ROD_VERTEX = `precision highp float;
in vec3 position; // on a unit sphere, its axis along z
in vec3 from;
in vec3 to;
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
  vec3 along = to - from;
  float length_ = length(along);
  vec3 axis = length_ > 1e-9 ? along / length_ : vec3(0.0, 0.0, 1.0);
  vec3 u = normalize(cross(axis, abs(axis.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0)));
  vec3 v = cross(axis, u);
  bool far = position.z > 0.0;
  normal = normalize(position.x * u + position.y * v + position.z * axis);
  place = (far ? to : from) + (far ? radii.y : radii.x) * normal;
  place = (modelMatrix * vec4(place, 1.0)).xyz;
  sideTone = side;
  lightTone = light;
  gl_Position = projectionMatrix * viewMatrix * vec4(place, 1.0);
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

/** Return the shape of a rod, whose ends the shader moves apart. */
function rodGeometry() {
  const points = [];
  const rings = 2 * RINGS + 2;
  for (let ring = 0; ring < rings; ring++) {
    const far = ring > RINGS;
    const step = far ? ring - RINGS - 1 : ring - RINGS;
    // Rings at the equators are moved a little to tell to which end they belong.
    const angle = (step / RINGS) * (Math.PI / 2) + (step ? 0 : far ? 1e-4 : -1e-4);
    for (let i = 0; i < AROUND; i++) {
      const turn = (2 * Math.PI * i) / AROUND;
      const wide = Math.cos(angle);
      points.push(wide * Math.cos(turn), wide * Math.sin(turn), Math.sin(angle));
    }
  }
  const index = [];
  for (let ring = 0; ring + 1 < rings; ring++)
    for (let i = 0; i < AROUND; i++) {
      const [one, next] = [ring * AROUND + i, ring * AROUND + ((i + 1) % AROUND)];
      index.push(one, next, next + AROUND, one, next + AROUND, one + AROUND);
    }
  return [new Float32Array(points), index];
}

class Rods {
  /**
   * @param {[number, number, number, number, string][]} limbs ends, radii in m, and role
   * @param {Shades} shades
   */
  constructor(limbs, shades) {
    this.limbs = limbs;
    const count = limbs.length;
    const geometry = new THREE.InstancedBufferGeometry();
    const [points, index] = rodGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
    geometry.setIndex(index);
    for (const [name, size] of [["from", 3], ["to", 3], ["radii", 2], ["side", 3], ["light", 3]])
      geometry.setAttribute(name, instanced(count, size));
    geometry.instanceCount = count;
    limbs.forEach(([, , one, other], i) => geometry.attributes.radii.setXY(i, one, other));
    this.mesh = new THREE.Mesh(geometry, material(ROD_VERTEX, ROD_FRAGMENT, shades.uniforms));
    this.caster = castingMaterial(ROD_VERTEX, shades.uniforms);
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
    const { from, to } = this.mesh.geometry.attributes;
    this.limbs.forEach(([one, other], i) => {
      for (let axis = 0; axis < 3; axis++) {
        from.array[3 * i + axis] = points[3 * one + axis];
        to.array[3 * i + axis] = points[3 * other + axis];
      }
    });
    from.needsUpdate = to.needsUpdate = true;
  }
}
