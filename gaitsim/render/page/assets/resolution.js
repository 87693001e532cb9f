// How finely pictures are drawn: edges are smooth by more pixels than the page has, fewer where
// pictures are slow.

const FIRST = 8; // pictures that do not count
const TRIES = 4;
const SLOW = 1 / 33; // s a frame: slower ones lower the resolution
const COARSEST = 0.6; // pixels of the picture a pixel of the page
const FINEST = 2;
const DENSEST = 3; // the same, at most, on screens that are finer
const MOST = 8e6; // pixels of a picture

class Resolution {
  /** @param {boolean} coarse whether the processor draws */
  constructor(coarse) {
    /** Pixels of the picture a pixel of the page while something moves. */
    this.ratio = coarse ? 1 : Infinity;
    this.most = this.ratio;
    this.tries = TRIES;
    this.rest();
  }

  /**
   * Return the finest resolution, pixels of the picture a pixel of the page.
   * @param {number[]} size width and height of the picture, pixels of the page
   */
  finest([width, height]) {
    const wanted = Math.max(FINEST, Math.min(devicePixelRatio, DENSEST));
    return Math.min(wanted, Math.sqrt(MOST / width / height));
  }

  /**
   * Lower it where pictures are slow; raise it where they are fast again, a few times.
   * @param {number} seconds since the last picture
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

  /** Forget how long pictures took: the first ones after a rest are slow. */
  rest() {
    this.paces = [];
    this.skipped = 0;
  }
}

/**
 * Return what draws in three dimensions on a canvas; null where nothing does.
 * @param {HTMLCanvasElement} canvas
 * @returns {WebGL2RenderingContext | null}
 */
function contextOf(canvas) {
  const wishes = { alpha: false, antialias: false, powerPreference: "high-performance" };
  return canvas.getContext("webgl2", wishes);
}

/** Return whether pictures are drawn by the processor, with no graphics card. */
function drawnByProcessor() {
  const context = contextOf(document.createElement("canvas"));
  const names = context?.getExtension("WEBGL_debug_renderer_info");
  const name = names ? context.getParameter(names.UNMASKED_RENDERER_WEBGL) : "";
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}
