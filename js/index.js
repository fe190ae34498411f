// sqmap in Node and the browser: the C library compiled to WebAssembly, with arrays in and out. See index.d.ts.
import core from "./core.js";
import {read, structs, write} from "./structs.js";

/** Why a call failed: name ("E_MESH"), element, message and cure. */
export class SqmapError extends Error {
  constructor(name, element, what, cure) {
    super(`${element}: ${what}; ${cure}`);
    Object.assign(this, {name, element, what, cure});
  }
}

const refuse = (element, what, cure) => new SqmapError("E_ARGUMENT", element, what, cure);
const projections = new Map([["central", 0], ["normal", 1]]);
const layers = new Map([[1, 1], [2, 2], [3, 3], ["exact", 4], ["auto", 5], ["gate", 6]]);
const projectors = new Map([["newton", 0], ["pyramid", 1], ["printed", 2]]);
const forces = new Map([["full", 0], ["paper", 1]]);
const frictionLaws = new Map([["default", 0], ["coulomb", 1], ["paper", 2], ["none", 3]]);
const modes = new Map([["direct", 1], ["proxy", 2], ["coupled", 3]]);
const units = new Map([["um", 1e-6], ["mm", 1e-3], ["cm", 1e-2], ["dm", 0.1], ["m", 1], ["km", 1e3], ["in", 0.0254], ["ft", 0.3048]]);
const ownWords = 2;  // sqmap_words: messages name these options
const cures = ["", "closed", "wrapped"];
const solids = new Map([["as-is", 0], ["outer", 1]]);
const features = ["vertex", "edge", "face"];
const full = 8;  // SQMAP_FULL: there are more contacts than space for them
const repairs = new Map([["wrap", 4], ["close", 3], ["safe", 2], ["none", 1]]);

function member(map, value, element) {
  if (!map.has(value)) throw refuse(element, `is ${String(value)}`, `take one of ${[...map.keys()].join(", ")}`);
  return map.get(value);
}

const kindOf = (value) => (value === null ? "null" : typeof value);

function number(value, element) {
  if (typeof value !== "number") throw refuse(element, `is ${kindOf(value)}`, "give a number");
  return value;
}

function whole(value, element) {
  if (!Number.isSafeInteger(value) || value < 0) throw refuse(element, `is ${String(value)}`, "give a whole number from 0");
  return value;
}

function flag(value, element) {
  if (typeof value !== "boolean") throw refuse(element, `is ${kindOf(value)}`, "give true or false");
  return value ? 1 : 0;
}

/** Metres per unit of a mesh; 0 where its own is kept. */
function metresPer(unit) {
  if (unit === undefined) return 0;
  if (typeof unit === "string") return member(units, unit, "options.unit");
  if (number(unit, "options.unit") === 0) throw refuse("options.unit", "is 0", "give metres per unit");
  return unit;
}

/** A number in a place where zero stands for the default in C and below zero for none. */
function orNothing(value, element) {
  if (!(number(value, element) >= 0)) throw refuse(element, `is ${value}`, "give a number from 0 on");
  return value === 0 ? -1 : value;
}

/** How a paper model is read, as the structs of queries and sessions have it. */
function reading({projector = "newton", gate = 10, nearestSteps = 2, gaps = true, pruning = true, offset = false}) {
  if (whole(gate, "options.gate") === 0) throw refuse("options.gate", "is 0", "give a number from 1 on, or take layer 2");
  if (whole(nearestSteps, "options.nearestSteps") > 100) throw refuse("options.nearestSteps", `is ${nearestSteps}`, "give at most 100");
  return {projector: member(projectors, projector, "options.projector"), gate: Math.min(gate, 0xffffffff),
          nearestSteps: nearestSteps === 0 ? -1 : nearestSteps, withoutGaps: 1 - flag(gaps, "options.gaps"),
          withoutPruning: 1 - flag(pruning, "options.pruning"), hasOffset: flag(offset, "options.offset")};
}

/** An object. */
function object(value, element) {
  if (typeof value !== "object" || value === null) throw refuse(element, `is ${kindOf(value)}`, "give an object");
  return value;
}

const querySettings = ["layer", "tolerance", "margin", "smooth", "pose", "projector", "gate", "nearestSteps", "gaps", "pruning", "offset"];
const pairSettings = ["layer", "tolerance", "margin", "firstOnly"];
const sessionSizes = ["metresPerUnit", "radius", "stiffness", "damping", "maxForce", "maxTorque", "continuousForce", "forceLimit", "torqueLimit",
                      "sidePath", "zone"];
const contactSettings = ["perRegion", "firstOnly"];
const bakeSettings = ["targetError", "band", "thickness", "maxParts", "repair", "projection", "surface", "exact", "locator", "keepInput", "unit",
                      "solid", "gap", "wrapTolerance", "source", "progress"];

/** An object of options that has no others than these: a name that is misspelt would leave the default unnoticed. */
function settings(value, names) {
  for (const name of Object.keys(object(value, "options")))
    if (!names.includes(name)) throw refuse(`options.${name}`, "is unknown", `take ${names.join(", ")}`);
  return value;
}

/** A pose's numbers in the names of this package: "pose.rotation[4]" is "pose[5]". */
const inMatrix = (element) => element.replace(/\.rotation\[(\d)\]$/, (_, k) => `[${4 * Math.floor(k / 3) + (k % 3)}]`)
  .replace(/\.translation\[(\d)\]$/, (_, k) => `[${4 * k + 3}]`).replace(/\.rotation$/, "");

/** A refusal of the library's, in the names of this package: "points.pose.rotation[4]" is "options.pose[5]". */
function argumentOf(element) {
  const own = inMatrix(element)
    .replace(/^points\.pose|^bodies\.a\.pose/, "options.pose").replace(/^bodies\.b\.pose/, "options.probePose")
    .replace(/^bodies\.[ab]\./, "").replace(/^points\.(xyz|count)/, "points").replace(/^(simulation|tick)\./, "")
    .replace(/^options\.(accepts|is|has|without)_/, "options.");
  return own.startsWith("options.") ? own.replace(/_([a-z])/g, (_, letter) => letter.toUpperCase()) : own;
}

/** The same of calls with two bodies, of a probe of triangles and of a pile. */
const argumentOfBodies = (element) => inMatrix(element).replace(/^bodies\./, "").replace(/^end_pose/, "pose").replace(/^touch\.end_pose_a/, "poseA")
  .replace(/^separation\.along/, "direction").replace(/^clearance\.within/, "distance");
const argumentOfMesh = (element) => element.replace(/^mesh\.triangle(s|_count)/, "triangles").replace(/^mesh\.vert(ices|ex_count)/, "points");
const argumentOfPile = (element) => inMatrix(element).replace(/^step\.pose/, "poses");

/** Numbers as an array of rows: typed arrays and lists of lists. */
function rows(value, element, width = 3) {
  const isTyped = ArrayBuffer.isView(value) && !(value instanceof DataView) && typeof value[0] !== "bigint";
  const flat = isTyped ? value : Array.isArray(value) ? value.flat() : undefined;
  if (flat === undefined) throw refuse(element, `is ${kindOf(value)}`, `give an array of ${width} numbers a row`);
  const odd = isTyped ? -1 : value.findIndex((row) => Array.isArray(row) && row.length !== width);
  if (odd >= 0) throw refuse(`${element}[${odd}]`, `has ${value[odd].length} numbers`, `give ${width} a row`);
  if (flat.length % width !== 0) throw refuse(element, `has ${flat.length} numbers`, `give ${width} a row`);
  if (!ArrayBuffer.isView(flat) && !flat.every((x) => typeof x === "number"))
    throw refuse(element, "has an entry that is no number", "give numbers alone");
  return flat;
}

/** Numbers of vertices, three a triangle. */
function indices(value, element) {
  const corners = rows(value, element);
  if (![...corners].every(Number.isInteger)) throw refuse(element, "has an entry that is no whole number", "give indices");
  return corners;
}

/** A matrix of 4 x 4, row by row, as rotation and translation. */
function poseNumbers(pose, element) {
  const m = rows(pose, element, 4);
  if (m.length !== 16) throw refuse(element, `has ${m.length} numbers`, "give a matrix of 4 x 4, row by row");
  return [m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10], m[3], m[7], m[11]];
}

/** The largest number of 32 bits stands for none. */
const orNone = (number) => (number === 0xffffffff ? -1 : number);

/** The other way. */
const matrixOf = ([a, b, c, d, e, f, g, h, i, x, y, z]) => [a, b, c, x, d, e, f, y, g, h, i, z, 0, 0, 0, 1];

/** Arguments of one call to the library: memory that is freed when it returns. */
class Call {
  constructor(library, nameOf = argumentOf) {
    this.library = library;
    this.nameOf = nameOf;
    this.blocks = [];
  }
  space(bytes) {
    const address = this.library._malloc(Math.max(1, bytes));
    if (address === 0) throw new SqmapError("E_MEMORY", "WebAssembly", `has no ${bytes} bytes`, "query fewer points at a time");
    this.blocks.push(address);
    return address;
  }
  get view() {
    return new DataView(this.library.HEAPU8.buffer);
  }
  struct(kind, values = {}) {
    const address = this.space(structs[kind].bytes);
    write(this.view, structs[kind], address, values);
    return address;
  }
  read(kind, address, name) {
    return read(this.view, structs[kind], address, name);
  }
  /** Members of a struct that the library has written. */
  members(kind, address, names = Object.keys(structs[kind].members)) {
    const out = {};
    for (const name of names) if (name !== "size") out[name] = this.read(kind, address, name);
    return out;
  }
  /** The handle that open writes. */
  handle(open) {
    const at = this.space(8);
    open(at);
    return this.view.getBigUint64(at, true);
  }
  numbers(values) {
    const address = this.space(8 * values.length);
    new Float64Array(this.library.HEAPU8.buffer, address, values.length).set(values);
    return address;
  }
  text(value) {
    const bytes = new TextEncoder().encode(String(value));
    const address = this.space(bytes.length + 1);
    this.library.HEAPU8.set(bytes, address);
    this.library.HEAPU8[address + bytes.length] = 0;
    return address;
  }
  /** A number among the options of a bake as C takes it: zero, which stands for the default there, is -1. */
  option(value, name, check = number) {
    if (value === undefined) return 0;
    const given = check(value, `options.${name}`);
    if (!(given <= 0)) return given;  // the library judges it
    const [least, most] = [this.space(8), this.space(8)];
    this.run("sqmap_option_range", this.text(name.replace(/[A-Z]/g, (letter) => `_${letter.toLowerCase()}`)), least, most);
    const [from, to] = [least, most].map((at) => this.view.getFloat64(at, true));
    if (given < 0 || from > 0) throw refuse(`options.${name}`, `is ${given}`, `give a number from ${from} to ${to}, or leave it out`);
    return -1;
  }
  pose(pose, element = "options.pose") {
    return pose === undefined ? 0 : this.numbers(poseNumbers(pose, element));
  }
  points(points, pose) {
    const xyz = rows(points, "points");
    return {count: xyz.length / 3, at: this.struct("points", {xyz: this.numbers(xyz), count: xyz.length / 3, pose: this.pose(pose)})};
  }
  options({layer = 3, tolerance = 0, margin = 0, band = 0, smooth = false, firstOnly = false, ...paper} = {}) {
    return this.struct("queryOptions", {
      layer: member(layers, layer, "options.layer"), tolerance: number(tolerance, "options.tolerance"),
      margin: number(margin, "options.margin"), band: number(band, "options.band"),
      isSmooth: flag(smooth, "options.smooth"), isFirstOnly: flag(firstOnly, "options.firstOnly"), ...reading(paper),
    });
  }
  mesh(xyz, corners) {
    const triangles = this.space(8 * corners.length), wide = new BigInt64Array(this.library.HEAPU8.buffer, triangles, corners.length);
    for (let i = 0; i < corners.length; ++i) wide[i] = BigInt(corners[i]);
    return this.struct("mesh", {vertices: this.numbers(xyz), vertexCount: xyz.length / 3, triangles, triangleCount: corners.length / 3});
  }
  /** The handles and the pose of a body that has a probe. */
  body(value, element) {
    const {model, probe, pose} = object(value, element);
    const odd = Object.keys(value).find((name) => !["model", "probe", "pose"].includes(name));
    if (odd !== undefined) throw refuse(`${element}.${odd}`, "is unknown", "take model, probe, pose");
    if (!(probe instanceof Probe)) throw refuse(`${element}.probe`, "is none", "make one with sqmap.probe(points, triangles)");
    if (model !== undefined && !(model instanceof Model)) throw refuse(`${element}.model`, "is none", "open or bake one, or leave it out");
    return {model: model === undefined ? 0n : model.handleFor(this.library, `${element}.model`),
            probe: probe.handleFor(this.library, `${element}.probe`), pose: this.pose(pose, `${element}.pose`)};
  }
  bodies(a, b) {
    const first = this.body(a, "a"), second = this.body(b, "b");
    return this.struct("bodies", {modelA: first.model, probeA: first.probe, poseA: first.pose,
                                  modelB: second.model, probeB: second.probe, poseB: second.pose});
  }
  contactOptions(options) {
    const {perRegion = 0, firstOnly = false} = settings(options, contactSettings);
    return {perRegion: Math.min(whole(perRegion, "options.perRegion"), 0xffffffff), isFirstOnly: flag(firstOnly, "options.firstOnly")};
  }
  surfaceContacts(address, count) {
    return Array.from({length: count}, (_, i) => {
      const row = this.members("surfaceContact", address + i * structs.surfaceContact.bytes);
      for (const name of ["featureA", "featureB"]) row[name] = features[row[name]];
      for (const name of ["indexA", "indexB", "region"]) row[name] = orNone(row[name]);
      return row;
    });
  }
  copy(type, address, length) {
    return new type(this.library.HEAPU8.buffer, address, length).slice();
  }
  /** Calls the library. @throws SqmapError */
  run(name, ...values) {
    const code = this.library[`_${name}`](...values);
    if (code === 0) return;
    const at = this.library._sqmap_last_error();
    const word = (what) => this.library.UTF8ToString(this.read("error", at, what));
    throw new SqmapError(word("name"), this.nameOf(word("element")), word("message"),
                         this.library.UTF8ToString(this.library._sqmap_last_cure(ownWords)));
  }
  /** A text that the library writes. */
  written(name, handle) {
    const text = this.struct("text", {words: ownWords});
    this.run(name, handle, text);
    const needed = this.read("text", text, "needed");
    const space = this.space(needed);
    write(this.view, structs.text, text, {text: space, capacity: needed});
    this.run(name, handle, text);
    return this.library.UTF8ToString(space);
  }
  end() {
    for (const block of this.blocks) this.library._free(block);
  }
}

/** Runs action with a Call that is freed whatever happens. */
function within(library, action, nameOf) {
  const call = new Call(library, nameOf);
  try {
    return action(call);
  } finally {
    call.end();
  }
}

/** Something of the library's with a handle. */
class Owned {
  #library;
  #handle;
  #closes;
  constructor(library, handle, closes) {
    this.#library = library;
    this.#handle = handle;
    this.#closes = closes;
  }
  get handle() {
    return this.#handle;
  }
  /** The open handle, for a call in which this is an argument. */
  handleFor(library, element) {
    if (this.#handle === 0n) throw new SqmapError("E_HANDLE", element, "is closed", "open it again");
    if (this.#library !== library) throw refuse(element, "is of another load()", "make it with the same one");
    return this.#handle;
  }
  /** Frees the memory; whatever is called afterwards throws. */
  close() {
    const handle = this.#handle;
    this.#handle = 0n;
    if (handle !== 0n) within(this.#library, (c) => c.run(this.#closes, handle));
  }
  within(action, nameOf) {
    if (this.#handle === 0n) throw new SqmapError("E_HANDLE", this.constructor.name, "is closed", "open it again");
    return within(this.#library, action, nameOf);
  }
}

/** Points, with the triangles between them if there are any, prepared once and queried many times. */
export class Probe extends Owned {
  constructor(library, handle, count, triangles) {
    super(library, handle, "sqmap_close_probe");
    Object.assign(this, {count, triangles});
  }
}

export class Model extends Owned {
  constructor(library, handle) {
    super(library, handle, "sqmap_close_model");
  }
  get facts() {
    return this.within((c) => {
      const at = c.struct("facts");
      c.run("sqmap_model_facts", this.handle, at);
      const facts = c.members("facts", at);
      facts.bytes = Number(facts.bytes);
      facts.cure = cures[facts.cure];
      for (const name of ["isSolid", "hasExact", "isNormal", "isDoubtful", "hasInput"]) facts[name] = facts[name] !== 0;
      return facts;
    });
  }
  get info() {
    return JSON.parse(this.within((c) => c.written("sqmap_info", this.handle)));
  }
  get notes() {
    return this.within((c) => c.written("sqmap_notes", this.handle)).split("\n").filter((line) => line !== "");
  }
  get mesh() {
    const {vertices, triangles} = this.facts;
    return this.within((c) => {
      const v = c.space(24 * vertices), t = c.space(12 * triangles), p = c.space(4 * triangles);
      c.run("sqmap_triangles", this.handle, v, t, p);
      return {vertices: c.copy(Float64Array, v, 3 * vertices), triangles: c.copy(Uint32Array, t, 3 * triangles),
              parts: c.copy(Int32Array, p, triangles)};
    });
  }
  get sources() {
    const {vertices, triangles} = this.facts;
    return this.within((c) => {
      const t = c.space(8 * triangles), v = c.space(8 * vertices);
      c.run("sqmap_sources", this.handle, t, v);
      const numbers = (at, count) => Int32Array.from(c.copy(BigInt64Array, at, count), Number);
      return {triangles: numbers(t, triangles), vertices: numbers(v, vertices)};
    });
  }
  toBytes() {
    return this.within((c) => {
      const out = c.space(8);
      c.run("sqmap_bytes", this.handle, out, out + 4);
      return c.copy(Uint8Array, c.view.getUint32(out, true), c.view.getUint32(out + 4, true));
    });
  }
  query(points, options = {}) {
    settings(options, querySettings);
    return this.within((c) => {
      const {count, at} = c.points(points, options.pose), chosen = c.options(options);
      const contact = c.space(count), certain = c.space(count), status = c.space(count), part = c.space(4 * count);
      const depth = c.space(8 * count), normal = c.space(24 * count), closest = c.space(24 * count);
      const out = c.struct("contacts", {contact, depth, normal, closest, part, certain, status});
      c.run("sqmap_query_points", this.handle, at, chosen, out);
      return {
        contact: c.copy(Uint8Array, contact, count), depth: c.copy(Float64Array, depth, count),
        normal: c.copy(Float64Array, normal, 3 * count), closest: c.copy(Float64Array, closest, 3 * count),
        part: c.copy(Int32Array, part, count), certain: c.copy(Uint8Array, certain, count),
        status: c.copy(Uint8Array, status, count), contacts: c.read("contacts", out, "contacts"),
      };
    });
  }
  distances(points, options = {}) {
    settings(options, ["band", "pose"]);
    return this.within((c) => {
      const {count, at} = c.points(points, options.pose), chosen = c.options(options);
      const triangle = c.space(4 * count);
      const known = c.space(count), status = c.space(count), part = c.space(4 * count);
      const distance = c.space(8 * count), gradient = c.space(24 * count), closest = c.space(24 * count);
      c.run(options.band === undefined ? "sqmap_exact_distances" : "sqmap_signed_distances", this.handle, at, chosen,
            c.struct("distances", {distance, gradient, closest, part, known, status, triangle}));
      return {
        distance: c.copy(Float64Array, distance, count), gradient: c.copy(Float64Array, gradient, 3 * count),
        closest: c.copy(Float64Array, closest, 3 * count), part: c.copy(Int32Array, part, count),
        known: c.copy(Uint8Array, known, count), status: c.copy(Uint8Array, status, count),
        triangle: c.copy(Int32Array, triangle, count),
      };
    });
  }
  closestPoints(points, options = {}) {
    settings(options, ["pose"]);
    return this.within((c) => {
      const {count, at} = c.points(points, options.pose);
      const closest = c.space(24 * count), distance = c.space(8 * count), triangle = c.space(4 * count);
      c.run("sqmap_closest_points", this.handle, at, 0, c.struct("closest", {closest, distance, triangle}));
      return {closest: c.copy(Float64Array, closest, 3 * count), distance: c.copy(Float64Array, distance, count),
              triangle: c.copy(Uint32Array, triangle, count)};
    });
  }
  implicit(part, points, options = {}) {
    settings(options, ["pose"]);
    return this.within((c) => {
      const {count, at} = c.points(points, options.pose), values = c.space(8 * count);
      c.run("sqmap_implicit", this.handle, Math.min(whole(part, "part"), 0xffffffff), at, values);
      return c.copy(Float64Array, values, count);
    });
  }
  probe(probe, options = {}) {
    settings(options, [...querySettings, "probePose", "firstOnly", "capacity"]);
    if (!(probe instanceof Probe)) throw refuse("probe", "is none", "make one with sqmap.probe(points)");
    return this.within((c) => {
      const chosen = c.options(options);
      const capacity = options.capacity === undefined ? probe.count : whole(options.capacity, "options.capacity");
      const contacts = c.space(structs.contact.bytes * capacity);
      const list = c.struct("contactList", {contacts, capacity});
      const bodies = c.struct("bodies", {modelA: this.handle, poseA: c.pose(options.pose),
                                         probeB: probe.handleFor(c.library, "probe"),
                                         poseB: c.pose(options.probePose, "options.probePose")});
      c.run("sqmap_query_probe", bodies, chosen, list);
      const found = c.read("contactList", list, "found"), anchor = c.read("contactList", list, "anchor");
      const out = [];
      for (let i = 0; i < Math.min(found, capacity); ++i) {
        const row = c.members("contact", contacts + i * structs.contact.bytes);
        row.point = row.point.map((x, k) => x + anchor[k]);
        out.push(row);
      }
      return {contacts: out, found, status: c.read("contactList", list, "status")};
    });
  }
}

const acts = {stop: 1, resume: 2, restart: 4, held: 8, disconnected: 16};

export class Session extends Owned {
  #sequence = 0n;
  constructor(library, handle) {
    super(library, handle, "sqmap_close_session");
  }
  tick(pose, time, options = {}) {
    const {sampleTime = time, sequence, ...done} = object(options, "options");
    return this.within((c) => {
      let bits = 0;
      for (const [name, yes] of Object.entries(done)) {
        if (!(name in acts)) throw refuse(`options.${name}`, "is unknown", `take sampleTime, sequence, ${Object.keys(acts).join(", ")}`);
        bits |= flag(yes, `options.${name}`) * acts[name];
      }
      const force = c.struct("force");
      c.run("sqmap_tick_session", this.handle, c.struct("tick", {
        time: number(time, "time"), sampleTime: number(sampleTime, "sampleTime"),
        sequence: typeof sequence === "bigint" ? sequence : BigInt(sequence === undefined ? ++this.#sequence : whole(sequence, "sequence")),
        pose: poseNumbers(pose, "pose"), acts: bits}), force);
      const out = c.members("force", force);
      out.isEngaged = out.isEngaged !== 0;
      out.tool = matrixOf(out.tool);
      return out;
    });
  }
  simulate(targets) {
    const xyz = rows(targets, "targets"), count = xyz.length / 3;
    return this.within((c) => {
      const positions = c.space(24 * count), forces = c.space(24 * count), depths = c.space(8 * count), tools = c.space(24 * count);
      c.run("sqmap_simulate", this.handle,
            c.struct("simulation", {targets: c.numbers(xyz), count, positions, forces, depths, tools}));
      return {positions: c.copy(Float64Array, positions, 3 * count), forces: c.copy(Float64Array, forces, 3 * count),
              depths: c.copy(Float64Array, depths, count), tools: c.copy(Float64Array, tools, 3 * count)};
    });
  }
}

/** Many bodies that move. */
export class Pile extends Owned {
  constructor(library, handle) {
    super(library, handle, "sqmap_close_pile");
  }
  add(body) {
    return this.within((c) => {
      const {model, probe, pose} = c.body(body, "body"), number = c.space(4);
      c.run("sqmap_add_body", this.handle, c.struct("body", {model, probe, pose}), number);
      return c.view.getUint32(number, true);
    }, argumentOfPile);
  }
  remove(number) {
    this.within((c) => c.run("sqmap_remove_body", this.handle, Math.min(whole(number, "number"), 0xffffffff)), argumentOfPile);
  }
  query(poses, options = {}) {
    return this.within((c) => {
      if (poses !== undefined && !Array.isArray(poses)) throw refuse("poses", `is ${kindOf(poses)}`, "give a list of poses");
      const moved = poses?.flatMap((pose, i) => poseNumbers(pose, `poses[${i}]`));
      const out = c.struct("pileContacts"), pair = structs.pilePair.bytes;
      c.run("sqmap_query_pile", this.handle, c.struct("pileStep", {
        ...c.contactOptions(options), threads: 1, pose: moved === undefined ? 0 : c.numbers(moved), count: poses?.length ?? 0}), out);
      const {pairs, contacts, pairCount, count, near, status} = c.members("pileContacts", out), rows = c.surfaceContacts(contacts, count);
      return {pairs: Array.from({length: pairCount}, (_, i) => {
        const {first, count: length, ...row} = c.members("pilePair", pairs + i * pair);
        return {...row, contacts: rows.slice(first, first + length)};
      }), near, status};
    }, argumentOfPile);
  }
}

class Sqmap {
  #library;
  #workspace = 0n;
  #capacity = 0;
  constructor(library) {
    this.#library = library;
  }
  get version() {
    return this.#library.UTF8ToString(this.#library._sqmap_version());
  }
  get formatVersion() {
    return this.#library._sqmap_format_version();
  }
  open(bytes) {
    const data = bytes instanceof ArrayBuffer ? new Uint8Array(bytes) : bytes;
    if (!(data instanceof Uint8Array)) throw refuse("bytes", `is ${typeof bytes}`, "give a Uint8Array or ArrayBuffer");
    return within(this.#library, (c) => {
      const handle = c.space(8), at = c.space(data.length);
      this.#library.HEAPU8.set(data, at);
      c.run("sqmap_open_bytes", at, data.length, handle);
      return new Model(this.#library, c.view.getBigUint64(handle, true));
    });
  }
  bake(mesh, options = {}) {
    const {vertices, triangles} = object(mesh, "mesh");
    const xyz = rows(vertices, "vertices"), corners = indices(triangles, "triangles");
    return within(this.#library, (c) => {
      const mesh = c.mesh(xyz, corners);
      return this.#baked(c, options, (chosen, handle) => c.run("sqmap_bake", mesh, chosen, handle));
    });
  }
  bakeFile(name, bytes, options = {}) {
    if (!(bytes instanceof Uint8Array)) throw refuse("bytes", `is ${kindOf(bytes)}`, "give a Uint8Array");
    if (typeof name !== "string" || name === "") throw refuse("name", `is ${kindOf(name)}`, "give the file's name");
    object(options, "options");
    const path = `/tmp/${String(name).replace(/.*[/\\]/, "")}`;
    this.#library.FS.writeFile(path, bytes);
    try {
      return within(this.#library, (c) => this.#baked(c, {source: name, ...options},
                                                      (chosen, handle) => c.run("sqmap_bake_file", c.text(path), chosen, handle)));
    } finally {
      this.#library.FS.unlink(path);
    }
  }
  probe(points, triangles) {
    const xyz = rows(points, "points");
    if (triangles === undefined)
      return within(this.#library, (c) => new Probe(
        this.#library, c.handle((at) => c.run("sqmap_make_probe", c.points(xyz).at, at)), xyz.length / 3, 0));
    const corners = indices(triangles, "triangles");
    return within(this.#library, (c) => new Probe(
      this.#library, c.handle((at) => c.run("sqmap_make_solid_probe", c.mesh(xyz, corners), at)), xyz.length / 3, corners.length / 3),
                  argumentOfMesh);
  }
  pair(a, b, options = {}) {
    return this.#ofBodies(a, b, (c, bodies) => {
      const list = c.struct("pairList");
      c.run("sqmap_query_pair", bodies, c.options(settings(options, pairSettings)), this.#space(c, a, b), list);
      const {contacts, count, ...rest} = c.members("pairList", list);
      return {contacts: Array.from({length: count}, (_, i) => {
        const {vertexOf, isMutual, ...row} = c.members("pairContact", contacts + i * structs.pairContact.bytes);
        return {...row, vertexOf: vertexOf === 0 ? "a" : "b", isMutual: isMutual !== 0};
      }), ...rest};
    });
  }
  contacts(a, b, options = {}) {
    return this.#ofBodies(a, b, (c, bodies) => {
      const list = c.struct("surfaceList"), chosen = c.struct("contactOptions", c.contactOptions(options));
      for (let least = 4096;; least = 4 * this.#capacity) {
        c.run("sqmap_query_contacts", bodies, chosen, this.#space(c, a, b, least), list);
        const {contacts, count, ...rest} = c.members("surfaceList", list);
        if ((rest.status & full) === 0) return {contacts: c.surfaceContacts(contacts, count), ...rest};
      }
    });
  }
  overlap(a, b) {
    return this.#ofBodies(a, b, (c, bodies) => {
      const overlap = c.struct("overlap");
      c.run("sqmap_query_overlap", bodies, this.#space(c, a, b), overlap);
      return c.members("overlap", overlap);
    });
  }
  clearance(a, b) {
    return this.#ofBodies(a, b, (c, bodies) => {
      const clearance = c.struct("clearance");
      c.run("sqmap_query_clearance", bodies, clearance);
      const {within: reach, isWithin, triangleA, triangleB, ...rest} = c.members("clearance", clearance);
      return {...rest, triangleA: orNone(triangleA), triangleB: orNone(triangleB)};
    });
  }
  isWithin(a, b, distance) {
    if (!(number(distance, "distance") >= 0)) throw refuse("distance", `is ${distance}`, "give a number that is not below zero");
    if (distance === 0) return this.clearance(a, b).distance === 0;  // in C zero stands for the distance itself
    return this.#ofBodies(a, b, (c, bodies) => {
      const clearance = c.struct("clearance", {within: distance});
      c.run("sqmap_query_clearance", bodies, clearance);
      return c.read("clearance", clearance, "isWithin") !== 0;
    });
  }
  firstTouch(a, b, pose, poseA) {
    return this.#ofBodies(a, b, (c, bodies) => {
      const touch = c.struct("touch", {endPoseA: c.pose(poseA, "poseA")});
      c.run("sqmap_first_touch", bodies, c.numbers(poseNumbers(pose, "pose")), touch);
      const {touches, endPoseA: _, ...rest} = c.members("touch", touch);
      return {touches: touches !== 0, ...rest};
    });
  }
  firstTouchFeatures(start, end, options = {}) {
    const {edges = false, separation = 0} = settings(options, ["edges", "separation"]);
    const first = rows(start, "start", 12), last = rows(end, "end", 12), count = first.length / 12;
    if (last.length !== first.length) throw refuse("end", `has ${last.length} numbers`, `give ${first.length}, as start has`);
    return within(this.#library, (c) => {
      const touches = c.space(count), time = c.space(8 * count);
      c.run("sqmap_first_touch_features", c.struct("movingFeatures", {
        start: c.numbers(first), end: c.numbers(last), count, areEdges: flag(edges, "options.edges"),
        separation: number(separation, "options.separation")}), c.struct("touches", {time, touches}));
      return {touches: Array.from(c.copy(Uint8Array, touches, count), Boolean), time: c.copy(Float64Array, time, count)};
    }, (element) => element.replace(/^features\./, "options."));
  }
  separation(a, b, direction) {
    const along = direction === undefined ? [0, 0, 0] : rows(direction, "direction");
    if (along.length !== 3 || (direction !== undefined && !(along.every(Number.isFinite) && along.some((x) => x !== 0))))
      throw refuse("direction", `is ${along}`, "give three finite numbers, not all zero");
    return this.#ofBodies(a, b, (c, bodies) => {
      const separation = c.struct("separation", {along});
      c.run("sqmap_query_separation", bodies, this.#space(c, a, b), separation);
      const {along: _, isExact, ...rest} = c.members("separation", separation);
      return {...rest, isExact: isExact !== 0};
    });
  }
  pile(options = {}) {
    const {contacts = 4096} = settings(options, ["contacts"]);
    return within(this.#library, (c) => new Pile(
      this.#library, c.handle((at) => c.run("sqmap_make_pile", Math.min(whole(contacts, "options.contacts"), 0xffffffff), at))),
                  (element) => `options.${element}`);
  }
  session(model, options = {}) {
    const {pose, layer = 3, friction = 0.4, deadMan = false, mode = "direct", force = "full", frictionLaw = "default", fC = 0.2, kF = 100,
           projector, gate, nearestSteps, gaps, pruning, offset, tool, edges = true, ...sizes} = object(options, "options");
    if (!(model instanceof Model)) throw refuse("model", "is none", "open or bake one");
    const touched = model.handleFor(this.#library, "model");
    return model.within((c) => {
      const values = {pose: c.pose(pose), layer: member(layers, layer, "options.layer"), hasDeadMan: flag(deadMan, "options.deadMan"),
                      mode: member(modes, mode, "options.mode"),
                      friction: orNothing(friction, "options.friction"), force: member(forces, force, "options.force"),
                      frictionLaw: member(frictionLaws, frictionLaw, "options.frictionLaw"), fC: orNothing(fC, "options.fC"),
                      kF: orNothing(kF, "options.kF"), withoutEdges: 1 - flag(edges, "options.edges"),
                      ...reading({projector, gate, nearestSteps, gaps, pruning, offset})};
      if (tool !== undefined) {
        if (!(tool instanceof Probe)) throw refuse("options.tool", "is none", "make one with sqmap.probe(points, triangles)");
        values.tool = tool.handleFor(this.#library, "options.tool");
      }
      for (const [name, value] of Object.entries(sizes)) {
        if (!sessionSizes.includes(name)) throw refuse(`options.${name}`, "is unknown", "see index.d.ts");
        values[name] = number(value, `options.${name}`);
      }
      const handle = c.space(8);
      c.run("sqmap_make_session", touched, c.struct("sessionOptions", values), handle);
      return new Session(this.#library, c.view.getBigUint64(handle, true));
    });
  }
  #ofBodies(a, b, action) {
    return within(this.#library, (c) => action(c, c.bodies(a, b)), argumentOfBodies);
  }
  /** The memory that pairs are computed in, one for all calls: it grows with the largest body and with the most contacts. */
  #space(c, a, b, least = 4096) {
    const needed = Math.max(least, a.probe.count, b.probe.count);
    if (needed > this.#capacity) {
      const larger = c.handle((at) => c.run("sqmap_make_workspace", needed, at));
      if (this.#workspace !== 0n) c.run("sqmap_close_workspace", this.#workspace);
      [this.#workspace, this.#capacity] = [larger, needed];
    }
    return this.#workspace;
  }
  #baked(c, options, bake) {
    const {targetError, band, thickness = 0, maxParts, repair = "wrap", projection = "central", surface = false, exact = true,
           locator = true, keepInput = true, solid = "as-is", gap, wrapTolerance, unit, source, progress} = settings(options, bakeSettings);
    if (progress !== undefined && typeof progress !== "function")
      throw refuse("options.progress", `is ${kindOf(progress)}`, "give a function of a stage and the share that is done");
    if (source !== undefined && typeof source !== "string") throw refuse("options.source", `is ${kindOf(source)}`, "give a text");
    let failure;
    const called = progress === undefined ? 0 : this.#library.addFunction((context, stage, done) => {
      try {
        return progress(this.#library.UTF8ToString(stage), done) === false ? 1 : 0;
      } catch (error) {
        failure = error;
        return 1;
      }
    }, "iiid");
    const handle = c.space(8);
    const chosen = c.struct("bakeOptions", {
      targetError: c.option(targetError, "targetError"), band: c.option(band, "band"),
      thickness: number(thickness, "options.thickness"), maxParts: c.option(maxParts, "maxParts", whole),
      projection: member(projections, projection, "options.projection"), repair: member(repairs, repair, "options.repair"),
      acceptsSurface: flag(surface, "options.surface"), withoutExact: 1 - flag(exact, "options.exact"),
      withoutInput: 1 - flag(keepInput, "options.keepInput"), threads: 1, progress: called,
      source: source === undefined ? 0 : c.text(source), words: ownWords,
      unit: metresPer(unit), solid: member(solids, solid, "options.solid"), gap: c.option(gap, "gap"),
      wrapTolerance: c.option(wrapTolerance, "wrapTolerance"), withoutLocator: 1 - flag(locator, "options.locator"),
    });
    try {
      bake(chosen, handle);
    } catch (error) {
      throw failure ?? error;
    } finally {
      if (called !== 0) this.#library.removeFunction(called);
    }
    return new Model(this.#library, c.view.getBigUint64(handle, true));
  }
}

/** The bytes of sqmap.wasm beside this file. */
async function moduleBytes() {
  const url = new URL("./sqmap.wasm", import.meta.url);
  if (url.protocol !== "file:") {
    const response = await fetch(url);
    if (!response.ok) throw new SqmapError("E_FILE", String(url), `cannot be fetched: ${response.status}`, "serve it beside index.js");
    return response.arrayBuffer();
  }
  const {readFile} = await import("node:fs/promises");
  return readFile(url);
}

export async function load(options = {}) {
  const {wasm} = settings(options, ["wasm"]);
  if (wasm !== undefined && !(wasm instanceof Uint8Array) && !(wasm instanceof ArrayBuffer))
    throw refuse("options.wasm", `is ${kindOf(wasm)}`, "give a Uint8Array or ArrayBuffer");
  const library = await core({wasmBinary: new Uint8Array(wasm ?? await moduleBytes())});
  return new Sqmap(library);
}
