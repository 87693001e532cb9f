// The map of an archive: the best score in each cell of two axes, across all other axes.

const EMPTY = -1;
const MARGIN = { left: 58, right: 12, top: 10, bottom: 44 };

class CellMap {
  /**
   * @param {object} atlas axes with borders, places and values; scores; colours; lowest; raster
   * @param {(member: number) => void} choose called with the member of a selected cell
   * @param {(member: number) => void} point called with the member under the pointer, or EMPTY
   */
  constructor(atlas, choose, point) {
    Object.assign(this, { atlas, choose, point });
    this.least = -Infinity;
    this.selected = EMPTY;
    this.hovered = EMPTY;
    this.order = [...atlas.scores.keys()].sort((a, b) => atlas.scores[a] - atlas.scores[b]);
    this.canvas = gaitsim.element("canvas", {
      class: "cells",
      tabindex: "0",
      role: "application",
      "aria-roledescription": "map of gaits",
      "aria-describedby": "chosen",
      pointerdown: (event) => this._press(event),
      pointermove: (event) => this._hover(event),
      pointerleave: () => this._point(EMPTY),
      keydown: (event) => this._key(event),
    });
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  /**
   * Show one or two axes.
   * @param {number[]} axes indices
   */
  show(axes) {
    const { atlas } = this;
    this.axes = axes.map((index) => atlas.axes[index]);
    const [across, up] = this.axes;
    this.columns = across.borders.length - 1;
    this.rows = up ? up.borders.length - 1 : 1;
    this.cells = new Int32Array(this.columns * this.rows).fill(EMPTY);
    this.cellOf = new Int32Array(atlas.scores.length);
    if (atlas.raster)
      atlas.raster.forEach((member, i) => {
        const cell = (i % this.rows) * this.columns + Math.floor(i / this.rows);
        this.cells[cell] = member > 0 ? member - 1 : EMPTY;
      });
    for (const member of this.order) {
      const row = up ? up.places[member] : 0;
      const cell = row * this.columns + across.places[member];
      this.cellOf[member] = cell;
      if (!atlas.raster) this.cells[cell] = member;
    }
    const names = this.axes.map(({ name }) => name).join(" and ");
    this.canvas.setAttribute(
      "aria-label",
      `Map of ${atlas.scores.length} gaits by ${names}; arrow keys move between cells`,
    );
    this.draw();
  }

  /** @param {number} score threshold; cells below it are faint */
  set filter(score) {
    this.least = score;
    this.draw();
  }

  /** @param {number} member */
  select(member) {
    this.selected = member;
    this.draw();
  }

  /** @param {number} member @returns {number[]} members in the same cell of the map, best first */
  together(member) {
    const cell = this.cellOf[member];
    const same = this.atlas.raster
      ? [member]
      : this.order.filter((other) => this.cellOf[other] === cell);
    return same.reverse();
  }

  /** @param {number} score @returns {string} */
  colour(score) {
    const { colours, lowest, highest } = this.atlas;
    const share = (score - lowest) / (highest - lowest || 1);
    const place = Math.min(Math.max(share, 0), 1) * (colours.length - 1);
    const before = Math.min(Math.floor(place), colours.length - 2);
    const [one, other] = [gaitsim.rgb(colours[before]), gaitsim.rgb(colours[before + 1])];
    const mixed = one.map((value, i) => 255 * (value + (place - before) * (other[i] - value)));
    return `rgb(${mixed.map(Math.round).join(" ")})`;
  }

  /** @returns {{x: number, y: number, width: number, height: number}} area of the cells, pixels */
  _area() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    return {
      x: MARGIN.left,
      y: MARGIN.top,
      width: Math.max(width - MARGIN.left - MARGIN.right, 1),
      height: Math.max(height - MARGIN.top - MARGIN.bottom, 1),
    };
  }

  /** Return the positions of the borders, pixels. */
  _lines() {
    const { x, y, width, height } = this._area();
    const share = (axis, value) =>
      (value - axis.borders[0]) / (axis.borders.at(-1) - axis.borders[0]);
    const [across, up] = this.axes;
    return {
      columns: across.borders.map((value) => x + width * share(across, value)),
      rows: up
        ? up.borders.map((value) => y + height * (1 - share(up, value)))
        : [y + height, y],
    };
  }

  draw() {
    const { canvas, atlas } = this;
    const { clientWidth: width, clientHeight: height } = canvas;
    if (!width || !height || !this.axes) return;
    const ratio = Math.min(devicePixelRatio || 1, 2);
    canvas.width = width * ratio;
    canvas.height = height * ratio;
    const pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    const style = getComputedStyle(canvas);
    const { columns, rows } = this._lines();
    pen.fillStyle = style.getPropertyValue("--row");
    const area = this._area();
    pen.fillRect(area.x, area.y, area.width, area.height);
    const box = (cell) => {
      const [column, row] = [cell % this.columns, Math.floor(cell / this.columns)];
      const [x, y] = [columns[column], rows[row + 1]];
      return [x, y, columns[column + 1] - x, rows[row] - y];
    };
    this.cells.forEach((member, cell) => {
      if (member === EMPTY) return;
      pen.globalAlpha = atlas.scores[member] < this.least ? 0.12 : 1;
      pen.fillStyle = this.colour(atlas.scores[member]);
      const [x, y, w, h] = box(cell);
      pen.fillRect(x, y, w + 0.4, h + 0.4); // avoids hairlines between neighbours
    });
    pen.globalAlpha = 1;
    this._words(pen, style);
    for (const [member, colour] of [[this.hovered, "--soft"], [this.selected, "--pointer"]]) {
      if (member === EMPTY) continue;
      const [x, y, w, h] = box(this.cellOf[member]);
      const pad = Math.max(3, 6 - Math.min(w, h));
      pen.lineWidth = 4;
      pen.strokeStyle = style.getPropertyValue("--card");
      pen.strokeRect(x - pad, y - pad, w + 2 * pad, h + 2 * pad);
      pen.lineWidth = 2;
      pen.strokeStyle = style.getPropertyValue(colour);
      pen.strokeRect(x - pad, y - pad, w + 2 * pad, h + 2 * pad);
    }
  }

  /** Write the names and ends of the axes. */
  _words(pen, style) {
    const { x, y, width, height } = this._area();
    const [across, up] = this.axes;
    const named = ({ name, unit }) => (unit ? `${name} (${unit})` : name);
    pen.fillStyle = style.getPropertyValue("--soft");
    pen.font = `12px ${style.fontFamily}`;
    const ticks = (axis, place) => {
      const [low, high] = [axis.borders[0], axis.borders.at(-1)];
      for (const share of [0, 0.5, 1]) place(gaitsim.numeral(low + share * (high - low), 3), share);
    };
    pen.textBaseline = "top";
    ticks(across, (text, share) => {
      pen.textAlign = share === 0 ? "left" : share === 1 ? "right" : "center";
      pen.fillText(text, x + share * width, y + height + 5);
    });
    pen.textAlign = "center";
    pen.fillText(named(across), x + width / 2, y + height + 24, width);
    if (!up) return;
    pen.textAlign = "right";
    ticks(up, (text, share) => {
      pen.textBaseline = share === 0 ? "bottom" : share === 1 ? "top" : "middle";
      pen.fillText(text, x - 6, y + (1 - share) * height);
    });
    pen.save();
    pen.translate(14, y + height / 2);
    pen.rotate(-Math.PI / 2);
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    pen.fillText(named(up), 0, 0, height);
    pen.restore();
  }

  /** Return the nearest occupied cell within a finger's width of a point, or EMPTY. */
  _cellAt({ offsetX, offsetY }) {
    const { columns, rows } = this._lines();
    let [nearest, least] = [EMPTY, 22];
    this.cells.forEach((member, cell) => {
      if (member === EMPTY || this.atlas.scores[member] < this.least) return;
      const [column, row] = [cell % this.columns, Math.floor(cell / this.columns)];
      const beyond = (value, low, high) => Math.max(low - value, value - high, 0);
      const away = Math.hypot(
        beyond(offsetX, columns[column], columns[column + 1]),
        beyond(offsetY, rows[row + 1], rows[row]),
      );
      if (away < least) [nearest, least] = [cell, away];
    });
    return nearest;
  }

  _press(event) {
    const cell = this._cellAt(event);
    if (cell === EMPTY) return;
    this.canvas.focus({ preventScroll: true });
    this._choose(cell);
  }

  _hover(event) {
    const cell = this._cellAt(event);
    this._point(cell === EMPTY ? EMPTY : this.cells[cell]);
  }

  _point(member) {
    if (member === this.hovered) return;
    this.hovered = member;
    this.point(member);
    this.draw();
  }

  _choose(cell) {
    if (this.atlas.raster) this.cellOf[this.cells[cell]] = cell;
    this.choose(this.cells[cell]);
  }

  /** Select the nearest occupied cell in the direction of an arrow key. */
  _key(event) {
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    const step = way[event.key];
    if (event.key === "Home") this.choose(this.order.at(-1));
    if (!step && event.key !== "Home") return;
    event.preventDefault();
    if (!step || this.selected === EMPTY) return;
    const from = this.cellOf[this.selected];
    const [x, y] = [from % this.columns, Math.floor(from / this.columns)];
    let [nearest, least] = [EMPTY, Infinity];
    this.cells.forEach((member, cell) => {
      if (member === EMPTY || member === this.selected) return;
      if (this.atlas.scores[member] < this.least) return;
      const [dx, dy] = [(cell % this.columns) - x, Math.floor(cell / this.columns) - y];
      const ahead = dx * step[0] + dy * step[1];
      const aside = Math.abs(dx * step[1]) + Math.abs(dy * step[0]);
      const away = ahead + 3 * aside;
      if (ahead > 0 && away < least) [nearest, least] = [cell, away];
    });
    if (nearest !== EMPTY) this._choose(nearest);
  }
}
