// Bakes a mesh file into a model file through the npm package.
// usage: node bake.mjs PACKAGE MESH MODEL [normal]
import {readFileSync, writeFileSync} from "node:fs";
import {basename, resolve} from "node:path";
import {pathToFileURL} from "node:url";

const [folder, mesh, model, projection = "central"] = process.argv.slice(2);
const {load} = await import(pathToFileURL(resolve(folder, "index.js")));
const baked = (await load()).bakeFile(basename(mesh), readFileSync(mesh), {projection});
writeFileSync(model, baked.toBytes());
