// The rigid solids of robots, placed by their poses.

const SOLID_VERTEX = `precision highp float;
in vec3 position;
in vec3 direction;
uniform mat4 modelMatrix;
uniform mat4 viewMatrix;
uniform mat4 projectionMatrix;
out vec3 place;
out vec3 normal;

void main() {
  place = (modelMatrix * vec4(position, 1.0)).xyz;
  normal = mat3(modelMatrix) * direction;
  gl_Position = projectionMatrix * (viewMatrix * vec4(place, 1.0));
}
`;

const SOLID_FRAGMENT = `precision highp float;
in vec3 place;
in vec3 normal;
out vec4 colour;
uniform vec3 side;
uniform vec3 light;
${LIT}
void main() {
  colour = vec4(lit(side, light, normalize(normal), place), 1.0);
}
`;

const ROUND = 24; // corners of a round shape
const CREASED = 12; // maximum faces of a mesh with sharp edges; others are assumed to be round

class Solids {
  /**
   * @param {object[]} solids solids of a clip
   * @param {Shades} shades
   */
  constructor(solids, shades) {
    this.solids = solids;
    this.group = new THREE.Group();
    this.paints = {};
    for (const role of ["trunk", "left", "right", "damaged"])
      this.paints[role] = material(SOLID_VERTEX, SOLID_FRAGMENT, {
        ...shades.uniforms,
        side: { value: new THREE.Vector3() },
        light: { value: new THREE.Vector3() },
      });
    this.caster = castingMaterial(SOLID_VERTEX, shades.uniforms);
    this.meshes = solids.map((solid) => {
      const role = solid.damaged ? "damaged" : solid.side || "trunk";
      return new THREE.Mesh(solidGeometry(solid), this.paints[role]);
    });
    if (solids.length) this.group.add(...this.meshes);
  }

  /** @param {object} tones see `tonesOf` */
  paint(tones) {
    for (const [role, paint] of Object.entries(this.paints)) {
      paint.uniforms.side.value.fromArray(tones[role][0]);
      paint.uniforms.light.value.fromArray(tones[role][1]);
    }
  }

  /** @param {Pose} pose */
  show({ poses }) {
    this.meshes.forEach((mesh, i) => {
      const at = 7 * i;
      mesh.position.set(poses[at], poses[at + 1], poses[at + 2]);
      mesh.quaternion.set(poses[at + 4], poses[at + 5], poses[at + 6], poses[at + 3]);
    });
  }
}

/**
 * Return the surface of a solid in its own frame.
 * @param {object} solid solid with sizes as in gaitsim/contracts/rig.py
 */
function solidGeometry({ shape, size, vertices, faces }) {
  if (shape === "box") return polyhedron(...boxOf(size));
  if (shape === "mesh") return polyhedron(vertices, faces);
  if (shape === "sphere") return revolve(ballProfile(size[0], 0));
  if (shape === "ellipsoid") return revolve(ballProfile(1, 0), size);
  const [radius, half] = size;
  if (shape === "capsule") return revolve(ballProfile(radius, half));
  return revolve([
    [0, -half, 0, -1],
    [radius, -half, 0, -1],
    [radius, -half, 1, 0],
    [radius, half, 1, 0],
    [radius, half, 0, 1],
    [0, half, 0, 1],
  ]);
}

/** @param {number[]} half lengths @returns {[number[][], number[][]]} corners and triangles */
function boxOf([x, y, z]) {
  const corners = Array.from({ length: 8 }, (_, i) => [
    i & 4 ? x : -x,
    i & 2 ? y : -y,
    i & 1 ? z : -z,
  ]);
  const sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
  return [corners, sides.flatMap(fan)];
}

/**
 * Return half the outline of a capsule or a ball: distance from the axis, height, and normal.
 * @param {number} radius
 * @param {number} half half the length of the cylinder between the round ends
 */
function ballProfile(radius, half) {
  const steps = ROUND / 4;
  const profile = [];
  for (const end of [-1, 1])
    for (let i = 0; i <= steps; i++) {
      const angle = ((end < 0 ? i - steps : i) / steps) * (Math.PI / 2);
      const [wide, high] = [Math.cos(angle), Math.sin(angle)];
      profile.push([radius * wide, end * half + radius * high, wide, high]);
    }
  return profile;
}

/**
 * Return the surface of an outline revolved around the z axis.
 * @param {number[][]} profile outline from bottom to top
 * @param {number[]} scale scale along the axes
 */
function revolve(profile, scale = [1, 1, 1]) {
  const points = [];
  const normals = [];
  const index = [];
  profile.forEach(([wide, high, out, up], row) => {
    for (let i = 0; i <= ROUND; i++) {
      const angle = (2 * Math.PI * i) / ROUND;
      const [x, y] = [Math.cos(angle), Math.sin(angle)];
      points.push(wide * x * scale[0], wide * y * scale[1], high * scale[2]);
      const normal = [(out * x) / scale[0], (out * y) / scale[1], up / scale[2]];
      const length = Math.hypot(...normal);
      normals.push(...normal.map((value) => value / length));
      if (!row || i === ROUND) continue;
      const at = row * (ROUND + 1) + i;
      const below = at - ROUND - 1;
      index.push(below, below + 1, at + 1, below, at + 1, at);
    }
  });
  return surfaceOf(points, normals, index);
}

/**
 * Return the surface of flat faces, smoothed if there are many.
 * @param {number[][]} corners
 * @param {number[][]} triangles counter-clockwise from outside
 */
function polyhedron(corners, triangles) {
  const smooth = corners.map(() => [0, 0, 0]);
  const flats = triangles.map((triangle) => {
    const normal = normalOf(triangle.flatMap((corner) => corners[corner]), [0, 1, 2]);
    for (const corner of triangle) normal.forEach((value, axis) => (smooth[corner][axis] += value));
    return normal;
  });
  const planes = new Set(flats.map((normal) => normal.map((value) => value.toFixed(3)).join()));
  const round = planes.size > CREASED;
  const points = [];
  const normals = [];
  triangles.forEach((triangle, i) => {
    for (const corner of triangle) {
      points.push(...corners[corner]);
      const normal = round ? smooth[corner] : flats[i];
      const length = Math.hypot(...normal) || 1;
      normals.push(...normal.map((value) => value / length));
    }
  });
  return surfaceOf(points, normals, points.map((_, i) => i).slice(0, points.length / 3));
}

/** @param {number[]} points @param {number[]} normals @param {number[]} index */
function surfaceOf(points, normals, index) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(points), 3));
  geometry.setAttribute("direction", new THREE.BufferAttribute(new Float32Array(normals), 3));
  geometry.setIndex(index);
  return geometry;
}
