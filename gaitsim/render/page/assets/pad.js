// The buttons of the commands of a steered body: each is held like its key.

const SIGNS = { up: "↑", down: "↓", left: "←", right: "→", space: "Space" };

class Pad {
  /**
   * @param {{name: string, key: string, help: string}[]} commands
   * @param {(name: string, down: boolean) => void} press
   * @param {(name: string) => void} choose for good, by a click without a pointer, as of screen
   *   readers
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
   * Show which command is in force, and how much each controller has of it.
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
