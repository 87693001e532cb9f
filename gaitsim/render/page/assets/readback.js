// Pictures that the processor draws, put onto the page without waiting for them: browsers that read
// them back themselves stop meanwhile, and say so in the console.

const POLL = 2; // ms between two looks whether a picture is ready
const UNDER_WAY = 3; // pictures at a time

class Readback {
  /**
   * @param {WebGL2RenderingContext} gl of a canvas that is not shown
   * @param {HTMLCanvasElement} canvas that is; its style turns it upside down, as rows of a picture
   *   begin at the bottom
   */
  constructor(gl, canvas) {
    this.gl = gl;
    this.canvas = canvas;
    this.pen = canvas.getContext("2d", { alpha: false });
    /** @type {{buffer: WebGLBuffer, bytes: number}[]} */
    this.free = Array.from({ length: UNDER_WAY }, () => ({ buffer: gl.createBuffer(), bytes: 0 }));
    /** Pictures that are not ready, the oldest first. */
    this.pictures = [];
    canvas.style.transform = "scaleY(-1)";
  }

  /** Whether no other picture may be drawn now. */
  get busy() {
    return !this.free.length;
  }

  /**
   * Take the picture that was drawn.
   * @param {number} width pixels
   * @param {number} height pixels
   * @param {() => void} shown is called when it is on the page
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

  /** Show the pictures that are ready. */
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
