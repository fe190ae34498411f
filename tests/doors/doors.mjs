// The notes or the refusal of a mesh file through the npm package, as JSON, for doors_test.py.
// usage: node doors.mjs PACKAGE MESH
import {readFileSync} from "node:fs";
import {basename, resolve} from "node:path";
import {pathToFileURL} from "node:url";

const [folder, file] = process.argv.slice(2);
const {load, SqmapError} = await import(pathToFileURL(resolve(folder, "index.js")));
try {
  const model = (await load()).bakeFile(basename(file), readFileSync(file));
  console.log(JSON.stringify({notes: model.notes}));
} catch (error) {
  if (!(error instanceof SqmapError)) throw error;
  console.log(JSON.stringify({code: error.name, element: error.element, message: error.what, cure: error.cure}));
}
