// Builds ../plugins/gaitsim_page/assets/three.min.js: the classes in entry.js, from three.js.
import { copyFile, readFile } from "node:fs/promises";
import { build } from "esbuild";

const assets = new URL("../plugins/gaitsim_page/assets/", import.meta.url);
const three = new URL("node_modules/three/", import.meta.url);
const { version } = JSON.parse(await readFile(new URL("package.json", three), "utf8"));

// The viewer has its own shaders (RawShaderMaterial) and uses neither headsets nor environment
// maps. Leaving these out reduces the compressed file from 136 kB to 93 kB.
const left_out = [
  [/ShaderLib[\\/].*\.glsl\.js$/, 'export const vertex = ""; export const fragment = "";'],
  [/ShaderChunk[\\/].*\.glsl\.js$/, 'export default "";'],
  [/PMREMGenerator\.js$/, "export class PMREMGenerator {}"],
  [
    /WebXRManager\.js$/,
    `export class WebXRManager {
       constructor() { this.enabled = this.isPresenting = false; }
       addEventListener() {} removeEventListener() {} setAnimationLoop() {} dispose() {}
       getEnvironmentBlendMode() {}
     }`,
  ],
];

const lean = {
  name: "lean",
  setup(builder) {
    for (const [filter, contents] of left_out)
      builder.onLoad({ filter }, () => ({ contents, loader: "js" }));
  },
};

await build({
  entryPoints: ["entry.js"],
  outfile: new URL("three.min.js", assets).pathname,
  banner: { js: `/* three.js ${version}, MIT licence: see three.LICENSE */` },
  bundle: true,
  charset: "utf8",
  format: "iife",
  globalName: "THREE",
  legalComments: "none",
  minify: true,
  plugins: [lean],
  target: "es2022",
});
await copyFile(new URL("LICENSE", three), new URL("three.LICENSE", assets));
