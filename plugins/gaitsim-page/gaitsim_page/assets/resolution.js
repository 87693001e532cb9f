// The resolution of pictures: higher than that of the page, to smooth edges, or lower if drawing
// is slow.

const FIRST = 8; // pictures ignored after a pause
const TRIES = 4; // maximum number of increases
const SLOW = 1 / 33; // seconds per picture above which the resolution is reduced
const COARSEST = 0.6; // least pixels of the picture per pixel of the page
const FINEST = 2; // usual maximum of this ratio
const DENSEST = 3; // maximum of this ratio on high-resolution screens
const MOST = 8e6; // maximum pixels of a picture

class Resolution {
  /** @param {boolean} coarse whether rendering is done in software */
  constructor(coarse) {
    /** Pixels of the picture per pixel of the page during movement. */
    this.ratio = coarse ? 1 : Infinity;
    this.most = this.ratio;
    this.tries = TRIES;
    this.rest();
  }

  /**
   * Return the highest resolution, pixels of the picture per pixel of the page.
   * @param {number[]} size width and height of the picture, pixels of the page
   */
  finest([width, height]) {
    const wanted = Math.max(FINEST, Math.min(devicePixelRatio, DENSEST));
    return Math.min(wanted, Math.sqrt(MOST / width / height));
  }

  /**
   * Reduce the resolution if drawing is slow; increase it, a few times, if drawing is fast.
   * @param {number} seconds time since the last picture
   * @param {number[]} size
   */
  adapt(seconds, size) {
    if (this.skipped++ < FIRST || seconds > 1) return;
    this.paces.push(seconds);
    const whole = this.paces.reduce((sum, pace) => sum + pace, 0);
    if (this.paces.length < 16 && !(this.paces.length > 3 && whole > 0.8)) return;
    this.paces.sort((a, b) => a - b);
    const usual = this.paces[Math.floor(0.6 * this.paces.length)];
    this.paces = [];
    if (usual > SLOW) {
      const ratio = Math.min(this.ratio, this.finest(size));
      this.ratio = Math.max(COARSEST, ratio * clamp(SLOW / usual, 0.7, 0.88));
    } else if (usual < 0.6 * SLOW && this.ratio < this.most && this.tries-- > 0)
      this.ratio = Math.min(this.most, 1.2 * this.ratio);
  }

  /** Discard the measured times, as the first pictures after a pause are slow. */
  rest() {
    this.paces = [];
    this.skipped = 0;
  }
}

/**
 * Return the WebGL 2 context of a canvas; null if the browser has none.
 * @param {HTMLCanvasElement} canvas
 * @returns {WebGL2RenderingContext | null}
 */
function contextOf(canvas) {
  const options = { alpha: false, antialias: false, powerPreference: "high-performance" };
  return canvas.getContext("webgl2", options);
}

/** Return whether the browser renders in software, without a graphics card. */
function drawnByProcessor() {
  const context = contextOf(document.createElement("canvas"));
  const names = context?.getExtension("WEBGL_debug_renderer_info");
  const name = names ? context.getParameter(names.UNMASKED_RENDERER_WEBGL) : "";
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}
