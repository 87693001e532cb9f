"""Call a JavaScript function with data, in Node.js or else in Chromium."""

import json
import shutil
import subprocess

import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
FLAGS = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
"""Options of Chromium for WebGL rendered in software."""


def call(scripts, body, data):
    """Return the result of an asynchronous function body with `data` and the scripts."""
    text = f"(async () => {{{scripts}\n{body}}})()"
    if shutil.which("node"):
        read = "const data = JSON.parse(require('fs').readFileSync(0, 'utf8'));"
        script = f"{read}\n{text}.then((found) => console.log(JSON.stringify(found)));"
        found = subprocess.check_output(["node", "-e", script], input=json.dumps(data), text=True)
        return json.loads(found)
    playwright = pytest.importorskip("playwright.sync_api", reason="needs Node.js or Chromium")
    if CHROMIUM is None:
        pytest.skip("needs Node.js or Chromium")
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        return json.loads(
            browser.new_page().evaluate(f"async (data) => JSON.stringify(await {text})", data)
        )
