// Unpacks and runs the page's scripts, which are the only ones that the page's policy allows.
"use strict";
(async () => {
  const root = document.getElementById("gaitsim");
  try {
    for (const packed of document.querySelectorAll("script.packed")) {
      const bytes = Uint8Array.from(atob(packed.textContent), (letter) => letter.charCodeAt(0));
      const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
      const script = document.createElement("script");
      script.textContent = await new Response(stream).text();
      document.head.append(script);
    }
    const data = JSON.parse(document.getElementById("data").textContent);
    globalThis.gaitsimPage = await globalThis.gaitsim.start(data.kind, data, root);
  } catch (error) {
    const words = document.createElement("p");
    words.setAttribute("role", "alert");
    words.textContent = `This browser cannot show the motion; try a newer one. (${error.message})`;
    root.prepend(words);
  }
})();
