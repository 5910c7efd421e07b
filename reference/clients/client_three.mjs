// three.js's EXRLoader under Node (npm: three, in the folder that THREE names, or in the current one).

import { readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { pathToFileURL } from "node:url";

const [path, folder] = process.argv.slice(2);
const require = createRequire(join(process.env.THREE ?? process.cwd(), "package.json"));
let here;
try {
  here = require.resolve("three/examples/jsm/loaders/EXRLoader.js");
} catch (error) {
  console.error(error.message);
  process.exit(69);
}
const { EXRLoader } = await import(pathToFileURL(here));
const { FloatType, RedFormat, REVISION } = await import(pathToFileURL(join(dirname(here), "../../../build/three.module.js")));

const file = readFileSync(path);
let image;
try {
  image = new EXRLoader()
    .setDataType(FloatType)
    .parse(file.buffer.slice(file.byteOffset, file.byteOffset + file.byteLength));
} catch (error) {
  console.error(error.message);
  process.exit(1);
}
const { width, height, data, format } = image;
const names = format === RedFormat ? ["Y"] : ["R", "G", "B", "A"];
// The loader's rows start at the bottom, as textures do.
const planes = names.map((_, channel) =>
  Float32Array.from({ length: width * height }, (_, i) => {
    const row = height - 1 - Math.floor(i / width);
    return data[(row * width + (i % width)) * names.length + channel];
  }),
);
const said = { program: `three.js r${REVISION}`, channels: names, size: [width, height], color: "stored", place: null, whole: null, tags: {}, note: "" };
writeFileSync(join(folder, "read.json"), JSON.stringify(said));
writeFileSync(join(folder, "read.f32"), Buffer.concat(planes.map((plane) => Buffer.from(plane.buffer))));
