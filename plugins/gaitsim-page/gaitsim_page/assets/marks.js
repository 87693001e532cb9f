// Marks of feet: a disc in stance, a ring in swing, a cross for a lost leg.

const LIFTED = 0.06; // height of a disc above the ground, relative to its radius

const MARK_VERTEX = `precision highp float;
in vec2 corner;
in vec3 centre;
in vec3 upright; // normal of the ground for a foot in stance, else 0
in vec4 look; // colour and kind: 0 disc, 1 ring, 2 cross
uniform mat4 modelMatrix;
uniform mat4 viewMatrix;
uniform mat4 projectionMatrix;
uniform float radius;
out vec2 at;
out vec4 paint;

void main() {
  bool flat_ = dot(upright, upright) > 0.5;
  vec3 right = vec3(viewMatrix[0][0], viewMatrix[1][0], viewMatrix[2][0]);
  vec3 up = vec3(viewMatrix[0][1], viewMatrix[1][1], viewMatrix[2][1]);
  vec3 u = flat_ ? normalize(cross(vec3(0.0, 1.0, 0.0), upright)) : right;
  vec3 v = flat_ ? cross(upright, u) : up;
  at = 1.1 * corner;
  paint = look;
  vec3 place = (modelMatrix * vec4(centre, 1.0)).xyz + radius * (at.x * u + at.y * v);
  gl_Position = projectionMatrix * (viewMatrix * vec4(place, 1.0));
}
`;

const MARK_FRAGMENT = `precision highp float;
in vec2 at;
in vec4 paint;
out vec4 colour;
uniform vec3 outline;

void main() {
  float away = length(at);
  float pixel = max(fwidth(away), 1e-4);
  float inside;
  if (paint.w < 0.5) inside = clamp((1.0 - away) / pixel, 0.0, 1.0);
  else if (paint.w < 1.5) inside = clamp((0.12 - abs(away - 0.72)) / pixel + 0.5, 0.0, 1.0);
  else inside = clamp((0.16 - min(abs(at.x - at.y), abs(at.x + at.y)) * 0.7) / pixel + 0.5, 0.0, 1.0)
    * clamp((1.0 - away) / pixel, 0.0, 1.0);
  vec3 tone = paint.w < 0.5 ? mix(paint.rgb, outline, clamp((away - 0.9) / pixel, 0.0, 1.0) * 0.6) : paint.rgb;
  colour = vec4(tone, inside);
  if (inside < 0.01) discard;
}
`;

const KINDS = { disc: 0, ring: 1, cross: 2 };

class Marks {
  /**
   * @param {object} feet feet of a clip
   * @param {number} radius m
   * @param {Shades} shades
   */
  constructor(feet, radius, shades) {
    this.feet = feet;
    this.radius = radius;
    const geometry = new THREE.InstancedBufferGeometry();
    const corners = new Float32Array([-1, -1, 1, -1, 1, 1, -1, 1]);
    geometry.setAttribute("corner", new THREE.BufferAttribute(corners, 2));
    geometry.setIndex([0, 1, 2, 0, 2, 3]);
    for (const [name, size] of [["centre", 3], ["upright", 3], ["look", 4]])
      geometry.setAttribute(name, instanced(feet.names.length, size));
    geometry.instanceCount = feet.names.length;
    const uniforms = { ...shades.uniforms, radius: { value: radius } };
    this.mesh = new THREE.Mesh(
      geometry,
      material(MARK_VERTEX, MARK_FRAGMENT, uniforms, {
        ...BLENDED,
        polygonOffset: true,
        polygonOffsetFactor: -4,
        polygonOffsetUnits: -4,
      }),
    );
    this.mesh.renderOrder = ORDER.marks;
  }

  /** @param {object} theme */
  set theme(theme) {
    const colours = { left: theme.left, right: theme.right, "": theme.middle };
    this.colours = this.feet.names.map((_, i) =>
      rgb(this.feet.lost[i] ? theme.damaged : colours[this.feet.sides[i]]),
    );
  }

  /**
   * @param {Pose} pose
   * @param {Ground} ground
   * @param {number} lane lane of the body, m
   */
  show({ feet, touching }, ground, lane) {
    const { centre, upright, look } = this.mesh.geometry.attributes;
    this.feet.names.forEach((_, i) => {
      const [x, y, z] = [feet[3 * i], feet[3 * i + 1], feet[3 * i + 2]];
      const kind = this.feet.lost[i] ? "cross" : touching[i] ? "disc" : "ring";
      look.setXYZW(i, ...this.colours[i], KINDS[kind]);
      if (kind !== "disc") {
        upright.setXYZ(i, 0, 0, 0);
        centre.setXYZ(i, x, y, z);
        return;
      }
      const step = this.radius;
      const at = (dx, dy) => ground.height(x + dx, y + lane + dy);
      const slopes = [at(step, 0) - at(-step, 0), at(0, step) - at(0, -step)];
      const normal = [-slopes[0], -slopes[1], 2 * step];
      const length = Math.hypot(...normal);
      upright.setXYZ(i, ...normal.map((value) => value / length));
      centre.setXYZ(i, x, y, at(0, 0) + LIFTED * step);
    });
    centre.needsUpdate = upright.needsUpdate = look.needsUpdate = true;
  }
}
