// Asynchronous copying of software-rendered pictures to the page. Browsers that read such pictures
// back themselves block in the meantime and print warnings in the console.

const POLL = 2; // ms between checks for finished pictures
const MAX_PENDING = 3; // maximum pictures in progress

class Readback {
  /**
   * @param {WebGL2RenderingContext} gl context of a hidden canvas
   * @param {HTMLCanvasElement} canvas visible canvas; its style flips it, as the rows of pictures
   *   begin at the bottom
   */
  constructor(gl, canvas) {
    this.gl = gl;
    this.canvas = canvas;
    this.pen = canvas.getContext("2d", { alpha: false });
    /** @type {{buffer: WebGLBuffer, bytes: number}[]} */
    this.free = Array.from({ length: MAX_PENDING }, () => ({ buffer: gl.createBuffer(), bytes: 0 }));
    /** Unfinished pictures, the oldest first. */
    this.pictures = [];
    canvas.style.transform = "scaleY(-1)";
  }

  /** Whether the maximum number of pictures is in progress. */
  get busy() {
    return !this.free.length;
  }

  /**
   * Start to read the current picture back.
   * @param {number} width pixels
   * @param {number} height pixels
   * @param {() => void} shown called when the picture is on the page
   */
  take(width, height, shown) {
    const { gl } = this;
    const place = this.free.pop();
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, place.buffer);
    if (place.bytes !== 4 * width * height) {
      place.bytes = 4 * width * height;
      gl.bufferData(gl.PIXEL_PACK_BUFFER, place.bytes, gl.STREAM_DRAW);
    }
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, 0);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    const ready = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    this.pictures.push({ place, width, height, ready, shown });
    if (this.pictures.length === 1) setTimeout(() => this._look(), POLL);
  }

  /** Show the finished pictures. */
  _look() {
    const { gl, pictures } = this;
    while (pictures.length) {
      const { place, ready, shown } = pictures[0];
      const state = gl.isContextLost() ? gl.WAIT_FAILED : gl.clientWaitSync(ready, 0, 0);
      if (state === gl.TIMEOUT_EXPIRED) break;
      const picture = pictures.shift();
      if (state !== gl.WAIT_FAILED) this._show(picture);
      gl.deleteSync(ready);
      this.free.push(place);
      shown();
    }
    if (pictures.length) setTimeout(() => this._look(), POLL);
  }

  _show({ place, width, height }) {
    const { gl, canvas } = this;
    if (this.image?.width !== width || this.image.height !== height) {
      this.image = new ImageData(width, height);
      Object.assign(canvas, { width, height });
    }
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, place.buffer);
    gl.getBufferSubData(gl.PIXEL_PACK_BUFFER, 0, new Uint8Array(this.image.data.buffer));
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    this.pen.putImageData(this.image, 0, 0);
  }
}
