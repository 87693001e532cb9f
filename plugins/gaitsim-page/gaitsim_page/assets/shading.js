// The shading of surfaces: two tones of a colour, a dark outline, and haze on the far side.

const LIGHT = "normalize(vec3(0.3, -0.5, 0.81))"; // direction to the light, as in videos

const LIT = `
uniform vec3 cameraPosition;
uniform vec3 outline;
uniform vec3 haze;
uniform vec2 depths; // depth of the body's middle, and its span, m

vec3 lit(vec3 side, vec3 light, vec3 normal, vec3 place) {
  vec3 away = cameraPosition - place;
  float far = length(away);
  vec3 view = away / far;
  vec3 sun = ${LIGHT};
  float key = max(dot(normal, sun), 0.0);
  float sky = 0.5 + 0.5 * normal.z;
  vec3 colour = mix(side * (0.66 + 0.34 * sky), light, smoothstep(0.1, 1.0, 0.3 * sky + 0.72 * key));
  float shine = max(dot(normal, normalize(sun + view)), 0.0);
  shine *= shine;
  shine *= shine;
  shine *= shine;
  colour += 0.1 * shine * shine * shine;
  colour = mix(outline, colour, 0.45 + 0.55 * smoothstep(0.12, 0.42, dot(normal, view)));
  return mix(colour, haze, 0.3 * clamp((far - depths.x) / depths.y + 0.5, 0.0, 1.0));
}
`;

// The shadow of a body under light from above, stronger near the ground.
const CAST = `precision highp float;
in vec3 place;
out vec4 colour;
uniform vec2 under; // height of the ground, and the body's span, m

void main() {
  float height = max(place.z - under.x, 0.0) / under.y;
  colour = vec4(0.42 + 0.58 * exp(-5.0 * height));
}
`;

/**
 * Return a material.
 * @param {string} vertex
 * @param {string} fragment
 * @param {object} uniforms shared uniforms
 * @param {object} settings settings of the material
 */
function material(vertex, fragment, uniforms, settings = {}) {
  return new THREE.RawShaderMaterial({
    glslVersion: "300 es",
    vertexShader: vertex,
    fragmentShader: fragment,
    uniforms,
    ...settings,
  });
}

// Settings for blended materials that keep their place in `renderOrder` among opaque ones.
const BLENDED = { blending: THREE.CustomBlending, depthWrite: false, side: THREE.DoubleSide };

/** Drawing order. */
const ORDER = { surface: 0, shadow: 1, grid: 2, path: 3, body: 4, edges: 5, marks: 6 };

/**
 * Return the material of a body's shadow; where shadows overlap, the strongest one counts.
 * @param {string} vertex
 * @param {object} uniforms
 */
function castingMaterial(vertex, uniforms) {
  return material(vertex, CAST, uniforms, {
    blending: THREE.CustomBlending,
    blendEquation: THREE.MaxEquation,
    depthTest: false,
    depthWrite: false,
    side: THREE.DoubleSide,
  });
}

/** Colours and distances shared by all surfaces of a body. */
class Shades {
  /** @param {object} theme see gaitsim/render/scene/themes.py */
  constructor(theme) {
    this.uniforms = {
      outline: { value: new THREE.Vector3() },
      haze: { value: new THREE.Vector3() },
      depths: { value: new THREE.Vector2(1, 1) },
      under: { value: new THREE.Vector2(0, 1) },
    };
    this.theme = theme;
  }

  /** @param {object} theme */
  set theme(theme) {
    this.uniforms.outline.value.fromArray(rgb(theme.limb_edge));
    this.uniforms.haze.value.fromArray(rgb(theme.ground));
  }
}

/**
 * Return the dark and the light tone of each role of a body's parts.
 * @param {object} theme
 * @param {number} number index of the body
 */
function tonesOf(theme, number) {
  const own = rgb(theme.bodies[number % theme.bodies.length]);
  const damaged = rgb(theme.damaged);
  const limb = [rgb(theme.limb), rgb(theme.limb_light)];
  /** @param {string} colour */
  const tinted = (colour) => limb.map((tone) => mix(tone, rgb(colour), 0.4));
  return {
    limb,
    trunk: [mix(own, BLACK, 0.2), mix(own, WHITE, 0.3)],
    damaged: [damaged, mix(damaged, WHITE, 0.3)],
    left: tinted(theme.left),
    right: tinted(theme.right),
  };
}
