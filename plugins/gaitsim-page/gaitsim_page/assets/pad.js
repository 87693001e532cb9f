// Buttons for the commands of a steered body, held down like keys.

const SIGNS = { up: "↑", down: "↓", left: "←", right: "→", space: "Space" };

class Pad {
  /**
   * @param {{name: string, key: string, help: string}[]} commands
   * @param {(name: string, down: boolean) => void} press
   * @param {(name: string) => void} choose selects a command permanently, by a click without a
   *   pointer, such as that of a screen reader
   */
  constructor(commands, press, choose) {
    this.commands = commands;
    this.keys = commands.map((command) => this._key(command, press, choose));
    const keys = this.keys.map(({ key }) => key);
    const about = { class: "pad", role: "group", "aria-label": "Commands" };
    this.root = gaitsim.element("section", about, ...keys);
  }

  _key({ name, key, help }, press, choose) {
    const share = gaitsim.element("i", { class: "share" });
    const made = gaitsim.element(
      "button",
      {
        type: "button", class: `key ${key}`, title: help, "aria-label": `${name}: ${help}`,
        "aria-pressed": "false",
      },
      gaitsim.element("span", {}, SIGNS[key]), gaitsim.element("b", {}, name), share);
    made.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      made.setPointerCapture(event.pointerId);
      press(name, true);
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"])
      made.addEventListener(end, () => press(name, false));
    made.addEventListener("contextmenu", (event) => event.preventDefault());
    made.addEventListener("click", (event) => {
      if (event.detail === 0) choose(name);
    });
    return { key: made, share };
  }

  /**
   * Show the current command and the share of each controller.
   * @param {string} command
   * @param {number[] | undefined} shares
   */
  show(command, shares) {
    this.keys.forEach(({ key, share }, k) => {
      const inForce = this.commands[k].name === command;
      share.style.width = `${(100 * (shares?.[k] ?? Number(inForce))).toFixed(0)}%`;
      if (key.ariaPressed !== String(inForce)) key.ariaPressed = String(inForce);
    });
  }
}
