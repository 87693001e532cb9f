// The list of gaits beside the map, and notes on the page's accuracy.

const { element, numeral } = gaitsim;
const LISTED = 40; // gaits added to the list at a time

class GaitList {
  /**
   * @param {object} atlas data of the page
   * @param {CellMap} map
   * @param {(member: number) => void} choose called with the member of a selected row
   */
  constructor(atlas, map, choose) {
    Object.assign(this, { atlas, map, choose });
    this.listed = LISTED;
    this.rows = element("tbody", {});
    this.more = element("button", { type: "button", click: () => this.show(LISTED) }, "Show more");
    const orders = atlas.axes.flatMap(({ name }, i) => [
      element("option", { value: `${i}+` }, `${name}, highest first`),
      element("option", { value: `${i}-` }, `${name}, lowest first`),
    ]);
    const best = element("option", { value: "" }, "score, best first");
    this.sort = element("select", { change: () => this.show(0) }, best, ...orders);
    this.here = element("input", { type: "checkbox", change: () => this.show(0) });
    this.total = element("span", { class: "details" });
    const head = ["gait", "score"].map((text) => element("th", { scope: "col" }, text));
    this.column = element("th", { scope: "col" });
    this.root = element(
      "section",
      { class: "list" },
      element("h2", {}, "Gaits"),
      element(
        "p",
        { class: "choices" },
        element("label", {}, "Order ", this.sort),
        element("label", {}, this.here, " only this cell of the map"),
        this.total,
      ),
      element("table", {}, element("thead", {}, element("tr", {}, ...head, this.column)), this.rows),
      this.more,
    );
  }

  /** Update the list after the axes of the map or the selection have changed. */
  moved() {
    if (this.here.checked) this.show(0);
  }

  /** @param {number} member */
  set selected(member) {
    this.member = member;
    this.moved();
    this.rows.querySelectorAll("button").forEach((one) => {
      one.setAttribute("aria-pressed", String(Number(one.value) === member));
    });
  }

  /** Fill the list. @param {number} more gaits to add; 0 starts from the beginning */
  show(more) {
    const { axes, scores } = this.atlas;
    this.listed = more ? this.listed + more : LISTED;
    const axis = this.sort.value ? axes[parseInt(this.sort.value, 10)] : null;
    const sign = this.sort.value.endsWith("-") ? 1 : -1;
    const from = this.here.checked ? this.map.together(this.member) : [...this.map.order].reverse();
    const found = from.filter((member) => scores[member] >= this.map.least);
    if (axis) found.sort((a, b) => sign * (axis.values[a] - axis.values[b]));
    this.column.textContent = axis ? axis.name : "";
    const row = (member) => {
      const choose = { type: "button", value: member, click: () => this.choose(member) };
      const pressed = { "aria-pressed": member === this.member };
      return element(
        "tr",
        {},
        element("td", {}, element("button", { ...choose, ...pressed }, String(member + 1))),
        element("td", {}, numeral(scores[member])),
        element("td", {}, axis ? numeral(axis.values[member]) : ""),
      );
    };
    this.rows.replaceChildren(...found.slice(0, this.listed).map(row));
    this.more.hidden = found.length <= this.listed;
    this.total.textContent = `${found.length} ${found.length === 1 ? "gait" : "gaits"}`;
  }
}

/**
 * Return notes on the content and the accuracy of the page.
 * @param {object} atlas data of the page
 */
function notesOf({ gaits, made, axes, count, body, bodies }) {
  const degrees = (angle) => numeral((angle * 180) / Math.PI, 2);
  const words = [];
  if (axes.length > 2)
    words.push("A cell of the map shows the best gait across all other axes.");
  if (!gaits)
    words.push("The page cannot move this body, which lacks joint angles or links to move.");
  else {
    const shown = bodies ? "Each gait is shown on its own body, which" : "The body";
    const { body: shape, boxes } = new Rig(body ?? bodies.find(Boolean));
    const lowest = boxes ? "corner" : "foot";
    words.push(
      (shape.rests
        ? `${shown} is held in place and leans as it rests on its feet. The `
        : `${shown} is held in place, with its lowest ${lowest} on the ground and its trunk level. The `) +
        "score and the values show how far and how straight it goes; the picture does not.",
    );
    words.push(
      gaits.form === "waves"
        ? `The joint angles are the commanded ones; in all ${count} gaits, they differ from ` +
            `gaitsim's by at most ${gaits.error.toExponential(1)} rad.`
        : `One stride of each gait is repeated with the commanded joint angles, which differ ` +
            `from gaitsim's by at most ${degrees(gaits.error)}°.`,
    );
  }
  return element(
    "section",
    { class: "notes" },
    ...words.map((text) => element("p", {}, text)),
    element("p", { class: "made" }, `Created with ${made}.`),
  );
}
