// Pictures that the processor draws, put onto the page without waiting for them: browsers that read
// them back themselves stop meanwhile, and say so in the console.

const POLL = 2; // ms between two looks whether a picture is ready

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
    this.buffer = gl.createBuffer();
    this.busy = false;
    canvas.style.transform = "scaleY(-1)";
  }

  /**
   * Take the picture that was drawn.
   * @param {number} width pixels
   * @param {number} height pixels
   * @param {() => void} shown is called when it is on the page
   */
  take(width, height, shown) {
    const { gl } = this;
    if (this.image?.width !== width || this.image.height !== height) {
      this.image = new ImageData(width, height);
      this.bytes = new Uint8Array(this.image.data.buffer);
      gl.bindBuffer(gl.PIXEL_PACK_BUFFER, this.buffer);
      gl.bufferData(gl.PIXEL_PACK_BUFFER, this.bytes.length, gl.STREAM_DRAW);
    }
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, this.buffer);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, 0);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    const ready = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    this.busy = true;
    const look = () => {
      const state = gl.isContextLost() ? gl.WAIT_FAILED : gl.clientWaitSync(ready, 0, 0);
      if (state === gl.TIMEOUT_EXPIRED) return void setTimeout(look, POLL);
      this.busy = false;
      gl.deleteSync(ready);
      if (state !== gl.WAIT_FAILED) this._show();
      shown();
    };
    setTimeout(look, POLL);
  }

  _show() {
    const { gl, canvas, image } = this;
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, this.buffer);
    gl.getBufferSubData(gl.PIXEL_PACK_BUFFER, 0, this.bytes);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    if (canvas.width !== image.width) canvas.width = image.width;
    if (canvas.height !== image.height) canvas.height = image.height;
    this.pen.putImageData(image, 0, 0);
  }
}
