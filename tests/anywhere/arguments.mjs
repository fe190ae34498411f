// Every method of the npm package with every argument and every option missing, closed, of another library, of a wrong type or shape,
// or NaN: a SqmapError that names it. Methods and options are those of index.d.ts; a type that the table below does not know fails the
// test. An option of a name that there is not is tried too. Answers that are no errors are documented: NaN for a point that is not finite, no force for a tick.
// usage: node arguments.mjs PACKAGE
import assert from "node:assert/strict";
import {readFileSync} from "node:fs";
import {resolve} from "node:path";
import {pathToFileURL} from "node:url";

const folder = resolve(process.argv[2]);
const {load, Model, Probe, SqmapError} = await import(pathToFileURL(resolve(folder, "index.js")));
const types = readFileSync(resolve(folder, "index.d.ts"), "utf8").replace(/\/\*\*[\s\S]*?\*\//g, "").replace(/\/\/.*$/gm, "").replaceAll("=>", ":");

/** The texts between the commas of a list; commas within brackets part none. */
function split(list, separator = ",") {
  const out = [""];
  let depth = 0;
  for (const c of list) {
    depth += "({[<".includes(c) ? 1 : ")}]>".includes(c) ? -1 : 0;
    if (c === separator && depth === 0) out.push("");
    else out[out.length - 1] += c;
  }
  return out.map((text) => text.trim()).filter((text) => text !== "");
}
const member = (text) => {
  const [, name, optional, type] = text.match(/^(\w+)(\??):\s*([\s\S]+)$/);
  return {name, optional: optional === "?", type};
};

const interfaces = new Map(), methods = [];
for (const [, kind, name, base, body] of types.matchAll(/^export (interface|class) (\w+)(?: extends (\w+))? \{\n([\s\S]*?)^\}/gm)) {
  const lines = split(body, ";").map((line) => line.replace(/^readonly /, ""));
  interfaces.set(name, {base, members: lines.filter((line) => /^\w+\??:/.test(line)).map(member)});
  if (["Model", "Probe", "Session", "Pile", "Sqmap"].includes(name))
    for (const [, method, parameters] of lines.map((line) => line.match(/^(\w+)\(([\s\S]*)\):/)).filter(Boolean))
      methods.push({owner: name, method, parameters: split(parameters).map(member)});
}
const membersOf = (name) => {
  const {base, members} = interfaces.get(name);
  return [...(base ? membersOf(base) : []), ...members];
};

const sqmap = await load(), other = await load();
const identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], origin = [[0, 0, 0]], point = [[0, 0, 0], [0.1, 0, 0]];
const corners = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
const box = {vertices: Array.from({length: 8}, (_, i) => [(i >> 2) - 0.5, ((i >> 1) & 1) - 0.5, (i & 1) - 0.5]),
             triangles: corners.flatMap(([a, b, c, d]) => [[a, b, c], [a, c, d]])};
const off = new TextEncoder().encode(`OFF\n8 12 0\n${[...box.vertices, ...box.triangles.map((t) => [3, ...t])].map((r) => r.join(" ")).join("\n")}\n`);
const model = sqmap.bake(box), bytes = model.toBytes(), probe = sqmap.probe(point), theirs = other.open(bytes);
const solid = sqmap.probe(box.vertices, box.triangles), body = {model, probe: solid}, pile = sqmap.pile();
pile.add(body);
const closed = {Model: sqmap.open(bytes), Probe: sqmap.probe(point), Pile: sqmap.pile()};
for (const thing of Object.values(closed)) thing.close();

const shapes = [null, 5, "x", true, 1n, {}, [[1, 2]], [["a", "b", "c"]], new BigInt64Array(3), [1, 2, 3, 4]];
const notFinite = [NaN, Infinity, -Infinity].map((bad) => [[0, 0, 0], [0, bad, 0.9]]);
const poses = [...shapes, identity.slice(0, 9), new Array(16).fill(2), ...[0, 3, 5, 11].flatMap((k) => [NaN, Infinity].map((bad) =>
  identity.map((x, i) => (i === k ? bad : x))))];
const numbers = [null, "x", true, 1n, {}, [1], NaN, -Infinity], wholes = [null, "x", true, {}, [1], NaN, -1, 1.5, Infinity];
const flags = [null, 0, 1, "yes", {}, NaN], texts = [null, 5, true, {}, []], bytesWrong = [null, 5, "x", {}, [1, 2], 1n];

/** Wrong values by type; those of an argument that is missing are added where it is required. */
function wrong(type, name, method) {
  if (["maxParts", "capacity", "part", "sequence", "perRegion", "contacts", "number", "gate", "nearestSteps"].includes(name))
    return [...wholes, ...({part: [99, 2 ** 40], number: [99, 2 ** 40], contacts: [0, 2 ** 40], gate: [0], nearestSteps: [101]}[name] ?? [])];
  if (name === "direction") return [...shapes, ...notFinite.slice(0, 1), [0, 0, 0], [1, 2], [1, NaN, 0]];
  if (type === "Pose[]") return [null, 5, "x", true, {}, [5], [identity.slice(0, 9)], [new Array(16).fill(2)]];
  if (type === "Triangles") return [...shapes, [[0, 1, 99]], [[0, 1, -1]], [[0, 1, 1.5]], [[0, 1, NaN]], [[0, 1, 2]]];
  if (type === "Body") return [null, 5, "x", {}, ...wrong("Model").map((m) => ({...body, model: m})), {...body, model: null}, {...body, place: identity},
    ...[...wrong("Probe"), ...(method === "pair" ? [] : [probe]), undefined].map((p) => ({...body, probe: p})), ...wrong("Pose").map((p) => ({...body, pose: p}))];
  if (type === "Rows") return [...shapes, ...notFinite, ...(method === "probe" ? [[]] : [])];
  if (type === "Pose") return poses;
  if (type === "number") return numbers;
  if (type === "boolean") return flags;
  if (type === "string") return texts;
  if (type === "Layer") return [null, 0, 7, "deep", true, NaN, {}];
  if (type.startsWith('"')) return [...texts, "nonsense", ...(type.endsWith("number") ? [0, -1, NaN, Infinity] : [])].filter((x) => x !== 5 || !type.endsWith("number"));
  if (type.startsWith("(")) return [null, 5, "x", {}];
  if (type.startsWith("Uint8Array") && type.includes("ArrayBuffer")) return [...bytesWrong, new Uint8Array(64), bytes.slice(0, 999)];
  if (type === "Uint8Array") return bytesWrong;
  if (type === "Model") return [null, 5, {}, probe, closed.Model, theirs];
  if (type === "Probe") return [null, 5, {}, model, closed.Probe, other.probe(point)];
  if (type.startsWith("{vertices")) return [null, 5, {}, ...shapes.map((v) => ({...box, vertices: v})), ...notFinite.map((v) => ({...box, vertices: v})),
    ...[...shapes, [[0, 1, 99]], [[0, 1, -1]], [[0, 1, 1.5]], [[0, 1, NaN]]].map((t) => ({...box, triangles: t}))];
  if (type.startsWith("{pose?")) return [null, 5, "x", true];
  if (interfaces.has(type)) return [null, 5, "x", true];
  throw new Error(`no wrong values are known for ${type} of ${name}`);
}

const good = {points: point, vertices: box.vertices, mesh: box, name: "box.off", bytes, probe, model, part: 0, targets: [[2, 2, 2]], pose: identity, time: 0.5,
              a: body, b: body, body, distance: 1, number: 0, poses: [identity],
              start: [[1, 1, 1, 0, 0, 0, 4, 0, 0, 0, 4, 0]], end: [[1, 1, -1, 0, 0, 0, 4, 0, 0, 0, 4, 0]]};
const arguments_ = ({method, parameters}) => parameters.map(({name, optional}) => (optional ? undefined : method === "bakeFile" && name === "bytes" ? off : good[name]));
let tried = 0, named = 0, documented = 0;
const failures = [];

/** Calls with one thing wrong. names: of the thing, and what its error may be called by. */
function tries(call, names, value) {
  ++tried;
  const what = () => `${call.owner}.${call.method}, ${names[0]} = ${typeof value === "bigint" ? "1n" : JSON.stringify(value) ?? String(value)}`;
  let answer;
  try {
    answer = call.run();
  } catch (e) {
    if (!(e instanceof SqmapError) || !e.what || !e.cure || !names.some((name) => e.element.includes(name))) failures.push(`${what()}: ${e}`);
    ++named;
    return;
  }
  const numbersOf = ArrayBuffer.isView(answer) ? answer : answer?.distance ?? answer?.depth;
  const isTick = call.method === "tick" && answer.force.every((x) => x === 0) && (answer.acted & 1) === 1;
  if (isTick || (notFinite.includes(value) && Number.isNaN(numbersOf?.[1]) && !Number.isNaN(numbersOf[0]))) ++documented;
  else failures.push(`${what()}: answered`);
}

function thisOf(owner) {
  if (owner !== "Session") return {Model: model, Probe: probe, Pile: pile, Sqmap: sqmap}[owner];
  const session = sqmap.session(model);
  session.tick(identity, 0.4);
  return session;
}

for (const {owner, method, parameters} of methods.filter((m) => m.method !== "close")) {
  parameters.forEach(({name, optional, type}, index) => {
    const given = (value, at = index) => arguments_({method, parameters}).map((x, k) => (k === at ? value : x));
    const call = (value) => ({owner, method, run: () => thisOf(owner)[method](...given(value))});
    const aliases = [name, ...(name === "mesh" ? ["vertices", "triangles"] : []), ...(name === "bytes" ? ["model", "file"] : []),
                     ...(method === "bakeFile" ? ["box.off", "x"] : [])];
    for (const value of [...wrong(type, name, method), ...(optional ? [] : [undefined])])
      if (!(name === "name" && value === "x")) tries(call(value), aliases, value);
    const options = type.startsWith("{pose?") ? [{name: "pose", type: "Pose"}] : interfaces.has(type) && name === "options" ? membersOf(type) : [];
    for (const option of options)
      for (const value of wrong(option.type, option.name, method)) tries(call({[option.name]: value}), [`options.${option.name}`, option.name], value);
    if (name === "options") tries(call({softness: 1}), ["softness"], 1);  // a name that is misspelt
  });
}
for (const [kind, thing] of Object.entries(closed))
  for (const {owner, method, parameters} of methods.filter((m) => m.owner === kind && m.method !== "close"))
    tries({owner, method, run: () => thing[method](...arguments_({method, parameters}))}, [kind], "closed");
for (const options of [null, 5, "x", {wasm: null}, {wasm: 5}, {wasm: "x"}, {wasm: [1]}, {wsam: undefined}]) {
  ++tried;
  await load(options).then(() => failures.push(`load(${JSON.stringify(options)}): answered`),
                           (e) => (e instanceof SqmapError && /^options/.test(e.element) ? ++named : failures.push(`load: ${e}`)));
}
for (const name of ["facts", "info", "notes", "mesh", "sources"]) tries({owner: "Model", method: name, run: () => closed.Model[name]}, ["Model"], "closed");
assert.deepEqual(failures, []);
assert.ok(methods.length >= 15 && tried > 700, `${methods.length} methods, ${tried} values`);
console.log(`arguments: ${methods.length} methods, ${tried} wrong values, ${named} named by an error, ${documented} answered as documented`);
