// Lines with smooth edges and a width in pixels: the grid of the ground, paths and outlines.

const RIBBON_VERTEX = `precision highp float;
in vec2 corner;
in vec3 from;
in vec3 to;
in float strength;
uniform mat4 modelMatrix;
uniform mat4 viewMatrix;
uniform mat4 projectionMatrix;
uniform vec2 screen; // pixels
uniform float width; // pixels
out vec3 place;
out float across;
out float shade;

void main() {
  vec3 worldFrom = (modelMatrix * vec4(from, 1.0)).xyz;
  vec3 worldTo = (modelMatrix * vec4(to, 1.0)).xyz;
  vec3 a = (viewMatrix * vec4(worldFrom, 1.0)).xyz;
  vec3 b = (viewMatrix * vec4(worldTo, 1.0)).xyz;
  // Clip lines that extend behind the camera.
  float near = -projectionMatrix[3][2] / (1.0 - projectionMatrix[2][2]) * 1.01;
  float start = a.z > -near ? clamp((a.z + near) / (a.z - b.z), 0.0, 1.0) : 0.0;
  float stop = b.z > -near ? clamp((a.z + near) / (a.z - b.z), 0.0, 1.0) : 1.0;
  vec4 one = projectionMatrix * vec4(mix(a, b, start), 1.0);
  vec4 other = projectionMatrix * vec4(mix(a, b, stop), 1.0);
  vec2 along = (other.xy / other.w - one.xy / one.w) * screen;
  along /= max(length(along), 1e-6);
  float share = corner.x < 0.5 ? start : stop;
  gl_Position = corner.x < 0.5 ? one : other;
  across = corner.y * (0.5 * width + 0.6);
  gl_Position.xy += vec2(-along.y, along.x) * across * 2.0 / screen * gl_Position.w;
  place = mix(worldFrom, worldTo, share);
  shade = a.z > -near && b.z > -near ? 0.0 : strength;
}
`;

const RIBBON_FRAGMENT = `precision highp float;
in vec3 place;
in float across;
in float shade;
out vec4 colour;
uniform vec3 ink;
uniform float width;
uniform vec3 centre;
uniform float reach; // m: lines fade out around the centre

void main() {
  vec3 away = (place - centre) / reach;
  float near = max(1.0 - dot(away, away), 0.0);
  float edge = clamp(0.5 * width + 0.5 - abs(across), 0.0, 1.0) * min(width, 1.0);
  colour = vec4(ink, shade * edge * near * sqrt(near));
}
`;

class Ribbons {
  /**
   * @param {number} width pixels
   * @param {object} settings settings of the material
   */
  constructor(width, settings = {}) {
    this.width = width;
    this.uniforms = {
      screen: { value: new THREE.Vector2(1, 1) },
      width: { value: width },
      ink: { value: new THREE.Vector3() },
      centre: { value: new THREE.Vector3() },
      reach: { value: 1e9 },
    };
    this.geometry = new THREE.BufferGeometry();
    this.mesh = new THREE.Mesh(
      this.geometry,
      material(RIBBON_VERTEX, RIBBON_FRAGMENT, this.uniforms, {
        ...BLENDED,
        ...settings,
      }),
    );
    this.mesh.frustumCulled = false;
    this._grow(8);
  }

  /** @param {string} colour */
  set colour(colour) {
    this.uniforms.ink.value.fromArray(rgb(colour));
  }

  /**
   * Set the size of the picture.
   * @param {number} width pixels of the picture
   * @param {number} height pixels of the picture
   * @param {number} ratio pixels of the picture per pixel of the page
   */
  resize(width, height, ratio) {
    this.uniforms.screen.value.set(width, height);
    this.uniforms.width.value = this.width * ratio;
  }

  /**
   * Fade the lines around a point.
   * @param {ArrayLike<number>} centre
   * @param {number} reach m
   */
  fade(centre, reach) {
    this.uniforms.centre.value.set(centre[0], centre[1], centre[2]);
    this.uniforms.reach.value = reach;
  }

  /**
   * Replace the lines.
   * @param {ArrayLike<number>} ends (lines, 2, 3) m
   * @param {ArrayLike<number>} strengths (lines,) 0 to 1
   */
  set(ends, strengths) {
    const count = strengths.length;
    if (count > this.room) this._grow(count);
    const { from, to, strength } = this.geometry.attributes;
    for (let i = 0; i < count; i++)
      for (let corner = 4 * i; corner < 4 * i + 4; corner++) {
        for (let axis = 0; axis < 3; axis++) {
          from.array[3 * corner + axis] = ends[6 * i + axis];
          to.array[3 * corner + axis] = ends[6 * i + 3 + axis];
        }
        strength.array[corner] = strengths[i];
      }
    from.needsUpdate = to.needsUpdate = strength.needsUpdate = true;
    this.geometry.setDrawRange(0, 6 * count);
  }

  /**
   * Allocate lines with four corners each. Instanced drawing would need less memory, but takes
   * twenty times as long in software rendering.
   * @param {number} count
   */
  _grow(count) {
    this.room = Math.ceil(1.5 * count);
    this.geometry.dispose();
    const corners = [];
    const index = [];
    for (let i = 0; i < this.room; i++) {
      corners.push(0, -1, 1, -1, 1, 1, 0, 1);
      index.push(...[0, 1, 2, 0, 2, 3].map((corner) => 4 * i + corner));
    }
    const set = (name, values, size) =>
      this.geometry.setAttribute(name, new THREE.BufferAttribute(values, size));
    set("corner", new Float32Array(corners), 2);
    for (const [name, size] of [["from", 3], ["to", 3], ["strength", 1]])
      set(name, new Float32Array(4 * this.room * size), size).attributes[name].setUsage(
        THREE.DynamicDrawUsage,
      );
    this.geometry.setIndex(index);
  }
}

/**
 * Return an attribute with a row for each instance, which changes in each picture.
 * @param {number} count number of instances
 * @param {number} size numbers per instance
 */
function instanced(count, size) {
  const attribute = new THREE.InstancedBufferAttribute(new Float32Array(count * size), size);
  return attribute.setUsage(THREE.DynamicDrawUsage);
}
