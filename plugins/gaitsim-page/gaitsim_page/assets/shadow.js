// The soft shadow of a body on the ground: a blurred picture of the body from above.

const SIZE = 128; // width and height of that picture, pixels
const DRAPE = 36; // squares along each side of the shadow's sheet on uneven ground
const CASTERS = 1; // layer of the objects that cast a shadow

const SHEET_VERTEX = `precision highp float;
in vec3 position;
uniform mat4 viewMatrix;
uniform mat4 projectionMatrix;
uniform vec3 box; // x and y of the middle, and half the length of the sides, m
out vec2 at;

void main() {
  at = 0.5 + 0.5 * (position.xy - box.xy) / box.z;
  gl_Position = projectionMatrix * (viewMatrix * vec4(position, 1.0));
}
`;

const SHEET_FRAGMENT = `precision highp float;
in vec2 at;
out vec4 colour;
uniform sampler2D picture;
uniform vec3 ink;

void main() {
  float dark = texture(picture, at).r;
  colour = vec4(ink, dark);
  if (dark < 0.004) discard;
}
`;

const BLUR_VERTEX = `precision highp float;
in vec3 position;
out vec2 at;

void main() {
  at = 0.5 + 0.5 * position.xy;
  gl_Position = vec4(position.xy, 0.0, 1.0);
}
`;

const BLUR_FRAGMENT = `precision highp float;
in vec2 at;
out vec4 colour;
uniform sampler2D picture;
uniform vec2 direction;

void main() {
  // Five reads between pixels give a Gaussian filter of nine pixels.
  vec4 sum = 0.2270 * texture(picture, at);
  sum += 0.3162 * (texture(picture, at + 1.3846 * direction) + texture(picture, at - 1.3846 * direction));
  sum += 0.0703 * (texture(picture, at + 3.2308 * direction) + texture(picture, at - 3.2308 * direction));
  colour = sum;
}
`;

class Shadow {
  /** @param {object} theme */
  constructor(theme) {
    const options = { depthBuffer: false, generateMipmaps: false };
    this.targets = [0, 1].map(() => new THREE.WebGLRenderTarget(SIZE, SIZE, options));
    this.camera = new THREE.OrthographicCamera(-1, 1, 1, -1, 0, 1);
    this.camera.layers.set(CASTERS);
    this.sheet = {
      picture: { value: this.targets[0].texture },
      ink: { value: new THREE.Vector3() },
      box: { value: new THREE.Vector3(0, 0, 1) },
    };
    this.mesh = new THREE.Mesh(
      new THREE.BufferGeometry(),
      material(SHEET_VERTEX, SHEET_FRAGMENT, this.sheet, {
        ...BLENDED,
        depthTest: false,
      }),
    );
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = ORDER.shadow;
    this.blur = { picture: { value: null }, direction: { value: new THREE.Vector2() } };
    this.whole = new THREE.Mesh(
      new THREE.BufferGeometry(),
      material(BLUR_VERTEX, BLUR_FRAGMENT, this.blur, { depthTest: false, depthWrite: false }),
    );
    const corners = new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]);
    this.whole.geometry.setAttribute("position", new THREE.BufferAttribute(corners, 3));
    this.whole.frustumCulled = false;
    this.squares = 0;
    this.theme = theme;
  }

  /** @param {object} theme */
  set theme(theme) {
    this.sheet.ink.value.fromArray(rgb(theme.shadow));
  }

  /**
   * Draw the picture of a body and place its sheet on the ground.
   * @param {object} renderer
   * @param {object} scene
   * @param {Body} body
   * @param {Ground} ground
   */
  update(renderer, scene, body, ground) {
    const { low, high } = body.box;
    const half = 0.58 * Math.max(high[0] - low[0], high[1] - low[1], 0.3 * body.span);
    const [x, y] = body.box.middle;
    this.sheet.box.value.set(x, y, half);
    const camera = this.camera;
    camera.left = camera.bottom = -half;
    camera.right = camera.top = half;
    camera.position.set(x, y, high[2] + body.span);
    camera.far = high[2] - low[2] + 3 * body.span;
    camera.updateProjectionMatrix();
    body.shades.uniforms.under.value.set(ground.height(x, y), body.span);
    body.casting(true);
    renderer.setRenderTarget(this.targets[0]);
    renderer.clear();
    renderer.render(scene, camera);
    body.casting(false);
    for (const [from, to] of [[0, 1], [1, 0]]) {
      this.blur.picture.value = this.targets[from].texture;
      this.blur.direction.value.set(from ? 0 : 1.2 / SIZE, from ? 1.2 / SIZE : 0);
      renderer.setRenderTarget(this.targets[to]);
      renderer.render(this.whole, camera);
    }
    renderer.setRenderTarget(null);
    this._drape(ground, x, y, half);
  }

  /** @param {Ground} ground @param {number} x @param {number} y @param {number} half */
  _drape(ground, x, y, half) {
    const squares = ground.level ? 1 : DRAPE;
    if (squares !== this.squares) this._weave(squares);
    const { position } = this.mesh.geometry.attributes;
    for (let j = 0, at = 0; j <= squares; j++)
      for (let i = 0; i <= squares; i++, at++) {
        const across = x + half * ((2 * i) / squares - 1);
        const along = y + half * ((2 * j) / squares - 1);
        position.setXYZ(at, across, along, ground.height(across, along));
      }
    position.needsUpdate = true;
  }

  /** @param {number} squares along each side */
  _weave(squares) {
    this.squares = squares;
    const side = squares + 1;
    const index = [];
    for (let j = 0; j < squares; j++)
      for (let i = 0; i < squares; i++) {
        const one = j * side + i;
        index.push(one, one + 1, one + side + 1, one, one + side + 1, one + side);
      }
    this.mesh.geometry.dispose();
    const points = new Float32Array(3 * side * side);
    this.mesh.geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
    this.mesh.geometry.setIndex(index);
  }

  dispose() {
    this.targets.forEach((target) => target.dispose());
    this.mesh.geometry.dispose();
    this.whole.geometry.dispose();
  }
}
