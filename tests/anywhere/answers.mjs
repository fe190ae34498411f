// The hashes of answers.c through the npm package.
// usage: node answers.mjs PACKAGE MODEL
import {readFileSync} from "node:fs";
import {pathToFileURL} from "node:url";
import {resolve} from "node:path";
import {hashes} from "./hashes.mjs";

const [folder, file] = process.argv.slice(2);
const {load} = await import(pathToFileURL(resolve(folder, "index.js")));
for (const line of hashes((await load()).open(readFileSync(file)))) console.log(line);
