/** Contact and signed distance between complex shapes. Lengths are the mesh's own units; points are rows of x, y, z. */

/** Rows of three numbers: a typed array of 3 n numbers, or a list. */
export type Rows = Float64Array | Float32Array | number[] | number[][];
/** Rows of three numbers of points, counter-clockwise seen from outside. */
export type Triangles = Uint32Array | Int32Array | number[] | number[][];
/** A matrix of 4 x 4, row by row, from the mesh's frame to the points'. */
export type Pose = Float64Array | Float32Array | number[] | number[][];
/** 1 superquadrics and polytopes, 2 planes, 3 planes and maps, "exact" triangles, "auto" the cheapest within tolerance; "gate": of each
 *  part of a paper model 3 where its base map is sparse, else 2. */
export type Layer = 1 | 2 | 3 | "exact" | "auto" | "gate";

/** Why a call failed. */
export class SqmapError extends Error {
  readonly name: string;     // "E_ARGUMENT", "E_MODEL", "E_VERSION", "E_HANDLE"; of a mesh the gate's own: "E_OPEN"
  readonly element: string;  // where, from zero: "triangles[3]", "points[3]", "options.band"
  readonly what: string;     // what was found
  readonly cure: string;     // what helps
}

/** How a paper model (projection "normal") is read. Options that change nothing are refused. */
export interface Reading {
  projector?: "newton" | "pyramid" | "printed";  // how feet are found: exactly, by the paper's search corrected, or to the letter; default "newton"
  gate?: number;          // k_L of the layer "gate", from 1; default 10
  nearestSteps?: number;  // to the nearest surface, layer 3, Newton's foot, 0 to 100; default 2
  gaps?: boolean;         // openings behind the first surface count, layer 3; default true
  pruning?: boolean;      // a part that proves a point free outweighs others; default true
  offset?: boolean;       // the surface moved out by eq. 12, of either projection; default false
}
/** How points are queried. */
export interface QueryOptions extends Reading {
  layer?: Layer;        // default 3
  tolerance?: number;   // of "auto"
  margin?: number;      // the surface is moved out by so much
  smooth?: boolean;     // depth and normal of the smoothed map
  pose?: Pose;
}
/** The answers for n points. */
export interface Contacts {
  contact: Uint8Array;    // n; 1: inside
  depth: Float64Array;    // n; 0 where free, NaN of a point that is not finite
  normal: Float64Array;   // 3 n; unit, outward
  closest: Float64Array;  // 3 n; the nearest surface point; the point itself where free
  part: Int32Array;       // n; -1 where free
  certain: Uint8Array;    // n; 1: the verdict is proven
  status: Uint8Array;     // n; bits: 1 not finite, 2 no exact layer, 4 no surface, 16 made up, 128 not given
  contacts: number;       // how many are inside
}

/** How distances are queried. */
export interface DistanceOptions {
  band?: number;  // in float, exact within it on either side, 0 as baked, which is quickest; default: exact in double everywhere
  pose?: Pose;
}
/** The answers for n points. */
export interface Distances {
  distance: Float64Array;  // n; negative inside; NaN of a point that is not finite
  gradient: Float64Array;  // 3 n; unit, away from the solid
  closest: Float64Array;   // 3 n
  part: Int32Array;        // n
  known: Uint8Array;       // n; 0 exact, 1 approximate, 2 a bound: no farther than the truth, at least half of it,
                           // 3 exact in float, of a model without its input
  status: Uint8Array;      // n
  triangle: Int32Array;    // n; of mesh, that holds the closest point; -1 of a bound
}
/** The answers for n points; nearest points of the triangles in double precision. */
export interface ClosestPoints {
  closest: Float64Array;   // 3 n
  distance: Float64Array;  // n; never negative
  triangle: Uint32Array;   // n
}

/** How a probe is queried; pose is the model's. */
export interface ProbeOptions extends QueryOptions {
  probePose?: Pose;     // of the probe
  firstOnly?: boolean;  // stop at the first contact
  capacity?: number;    // contacts that are written; default as many as the probe has points
}
/** A point of a probe inside a model, in the frame of the poses. */
export interface ProbeContact {
  point: number[];   // the nearest surface point
  normal: number[];  // unit, outward
  depth: number;
  index: number;     // of the probe's point
  part: number;
  certain: number;
  status: number;
}

/** How features that move are tested. */
export interface FeatureOptions {
  /** Edges against edges; default false, points against triangles. */
  edges?: boolean;
  /** How far apart counts as touching; default 0. */
  separation?: number;
}

/** A solid where it is. */
export interface Body {
  probe: Probe;   // its vertices and triangles
  model?: Model;  // of the same mesh; without it nothing is found that is in it as a whole
  pose?: Pose;    // from the mesh's frame to that of the poses
}
/** How the vertices of two bodies are queried, each in the other's model. */
export interface PairOptions {
  layer?: Layer;        // default 3
  tolerance?: number;   // of "auto"
  margin?: number;      // the surfaces are moved out by so much
  firstOnly?: boolean;  // stop at the first contact
}
/** A vertex of one body in the other, in the frame of the poses. */
export interface PairContact {
  onA: number[]; onB: number[];  // onB = onA - depth normal
  normal: number[];              // unit, the direction in which b leaves a
  depth: number;
  index: number;                 // of the vertex in its body's probe
  part: number;                  // of the other body's model
  vertexOf: "a" | "b";
  certain: number;               // 1: the verdict is proven
  isMutual: boolean;             // seen from both sides
  status: number;
}
/** Vertices of two bodies in each other. */
export interface PairContacts {
  contacts: PairContact[];
  found: number;       // in both directions, before those seen twice were merged
  status: number;
  edgeLength: number;  // edges no longer that cross the other surface have an end among the contacts; 0: edges are missed
}
/** Which complete contacts are wanted. */
export interface ContactOptions {
  perRegion?: number;   // of a region the deepest is kept and those that span the largest area; default 0: all
  firstOnly?: boolean;  // stop at the first contact
}
/** A contact of two bodies, in the frame of the poses. */
export interface SurfaceContact {
  onA: number[]; onB: number[];  // onB = onA - depth normal
  normal: number[];              // unit, the direction in which b leaves a
  /** A vertex has its distance to the other surface, or along the normal to a face that bears it; others what separates the two features. */
  depth: number;
  featureA: "vertex" | "edge" | "face"; featureB: "vertex" | "edge" | "face";
  /** A vertex or a face by its number in the probe; an edge as 3 t + k, from corner k of triangle t to the next one; -1: the face
   *  that a vertex is below. */
  indexA: number; indexB: number;
  region: number;                // contacts of one region touch together; -1: a vertex that no face bears, while perRegion is 0
  partA: number; partB: number;  // of the models; -1: none
  certain: number;               // 1: the verdict is proven
  status: number;
}
/** Complete contacts of two bodies. */
export interface SurfaceContacts {
  contacts: SurfaceContact[];
  found: number;     // kept or not
  meetings: number;  // pairs of triangles that have a point in common
  regions: number;   // of such pairs, each one connected; every one has a contact
  status: number;
}
/** The volume that two solids share. */
export interface Overlap {
  volume: number;
  error: number;  // what the shift of faces in special position changes at most, without rounding
  status: number;
}
/** The least distance of two solids. */
export interface Clearance {
  distance: number;                      // 0 where they have a point in common
  atLeast: number;                       // the truth is not below it
  onA: number[]; onB: number[];          // the nearest points
  triangleA: number; triangleB: number;  // that hold them; -1 where one solid is in the other
  status: number;
}
/** The translation of b that separates it from a. */
export interface Separation {
  distance: number;     // along direction; then they only touch
  atLeast: number;      // no shorter translation of those in question separates them
  direction: number[];  // unit
  isExact: boolean;     // both bounds differ by rounding alone
  status: number;
}
/** contacts: of a pair in one direction, for which there is space at first; it grows where a pair has more. Default 4096. */
export interface PileOptions {
  contacts?: number;
}
/** Two bodies of a pile that touch: their numbers, and what contacts(a, b) gives of them. */
export interface PilePair extends SurfaceContacts {
  a: number; b: number;
}

/** How to bake; the defaults are those of `sqmap bake`. A number out of range is refused with its range; band and gap may be 0. */
export interface BakeOptions {
  targetError?: number;  // percent of R_max, 99th percentile of layer 3's depth; default 0.5
  band?: number;         // percent of R_max, within which distances are exact; default 5
  thickness?: number;    // open meshes become plates this thick, units of the model
  unit?: "um" | "mm" | "cm" | "dm" | "m" | "km" | "in" | "ft" | number;  // of the mesh, or metres per unit: the model is in metres
  maxParts?: number;     // default 24
  projection?: "central" | "normal";
  repair?: "wrap" | "close" | "safe" | "none";
  solid?: "as-is" | "outer";  // outer: one body about all triangles, proven to hold them, of what cannot be reached from outside
  gap?: number;          // share of R_max: narrower gaps of an outer solid are closed; default 0.01
  wrapTolerance?: number;  // share of R_max that outer and wrapped solids may be off; default 0.002
  surface?: boolean;     // an open mesh is taken as a surface without inside
  exact?: boolean;       // default true; false leaves out the triangles
  locator?: boolean;     // default true; false leaves out the locator and the triangles: maps alone answer
  keepInput?: boolean;   // default true; false leaves out their coordinates and numbers as given: distances are in float then
  source?: string;       // what info names as the model's source
  progress?: (stage: string, done: number) => boolean | void;  // false: stop
}

/** Facts of a model; lengths in the mesh's units. rMax: the largest distance between two vertices; band: within it distances are
 *  exact; centre, radius: of a sphere that holds the object; isDoubtful: layer 3 has wrong verdicts or a depth p99 above 0.5 % of rMax, "auto" is exact;
 *  cure: how the mesh became a solid, "" as it was given or repaired. */
export interface Facts {
  rMax: number; band: number; centre: number[]; radius: number; bytes: number;
  parts: number; vertices: number; triangles: number;
  isSolid: boolean; hasExact: boolean; isNormal: boolean; isDoubtful: boolean; hasInput: boolean; cure: "" | "closed" | "wrapped";
}

/** Points, with the triangles between them if there are any, prepared once and queried many times. */
export class Probe {
  readonly count: number;
  readonly triangles: number;  // how many; complete contacts need them
  /** Frees the memory; whatever is called afterwards throws. */
  close(): void;
}

/** A baked model. */
export class Model {
  readonly facts: Facts;
  /** All that `sqmap info --json` prints. */
  readonly info: Record<string, unknown>;
  /** Repairs, how far they moved the surface and warnings of the bake, of a model that was opened too; info.notes has their numbers. */
  readonly notes: string[];
  /** The baked triangles and the part of each. @throws SqmapError of a model without them */
  readonly mesh: {vertices: Float64Array; triangles: Uint32Array; parts: Int32Array};
  /** The number of each triangle and vertex of mesh in the mesh that was given; -1 where a cure made it up.
   *  @throws SqmapError of a model without its input */
  readonly sources: {triangles: Int32Array; vertices: Int32Array};
  /** The bytes of a model file. */
  toBytes(): Uint8Array;
  /** Which points are inside, how deep, and in which direction out. */
  query(points: Rows, options?: QueryOptions): Contacts;
  /** Signed distances on both sides: exact, in double; with options.band in float, and bounds beyond it. */
  distances(points: Rows, options?: DistanceOptions): Distances;
  /** @throws SqmapError of a model without triangles */
  closestPoints(points: Rows, options?: {pose?: Pose}): ClosestPoints;
  /** F of eq. 1 of a part's superquadric: below 1 within it, 1 on its surface, above 1 outside. It is no distance. */
  implicit(part: number, points: Rows, options?: {pose?: Pose}): Float64Array;
  /** Which points of a probe are inside. */
  probe(probe: Probe, options?: ProbeOptions): {contacts: ProbeContact[]; found: number; status: number};
  /** Frees the memory; whatever is called afterwards throws. */
  close(): void;
}

/** The touched model, the tool, and the limits of the device. Metres, newtons, seconds. */
export interface SessionOptions extends Reading {
  metresPerUnit?: number;  // of the model's mesh; default 1
  pose?: Pose;             // of the model in the world, its translation in metres
  radius?: number;         // of the ball that touches, m; default 0: a point
  stiffness?: number;      // N/m; default 500
  damping?: number;        // N s/m; default 0
  friction?: number;       // Coulomb's; default 0.4
  layer?: Layer;
  maxForce?: number; maxTorque?: number; continuousForce?: number;  // what the device holds, N and N m; default: unknown, so careful
  forceLimit?: number; torqueLimit?: number;                        // the user's; default 2 N and 0.1 N m, or the device's
  deadMan?: boolean;       // force only in ticks that are held
  /** The tool is where the device is, stays on the surface while the device pulls it, or is a light body on springs; default
   *  "direct". */
  mode?: "direct" | "proxy" | "coupled";
  sidePath?: number;       // m, of the proxy; above 0 it stays on its side of thin parts; default 0
  force?: "full" | "paper";  // "paper": eqs. 21, 26 and 32 on the smoothed map of a paper model, mode "direct"; default "full"
  /** Default: eq. 33 with the paper's force, else Coulomb's. */
  frictionLaw?: "default" | "coulomb" | "paper" | "none";
  fC?: number; kF?: number;  // N and 1/m, of eq. 33; default 0.2 and 100
  tool?: Probe;            // triangles in metres, in the tool's frame; replaces the ball; it may be closed after the session is made
  edges?: boolean;         // where few points of the tool touch, its edges and faces do too; default true
  zone?: number;           // m, of a tool: the impact sphere about its pose, whose contacts count (section 6.1); default 0: all
}
/** The results of one tick: N, N m, m; world axes. */
export interface Force {
  force: number[];      // for the device: finite, within the limits, zero when anything is wrong
  torque: number[];     // about the tool
  commanded: number[];  // before the safety filter
  depth: number;        // of a proxy the stretch of its spring
  normal: number[];     // unit, outward; zero where free
  tool: number[];       // 4 x 4, row by row: the device's pose, the proxy's or the coupled body's
  status: number; acted: number; faults: number;  // bits of haptic::StepStatus, SafetyStep and SafetyFault
  isEngaged: boolean;   // all that is commanded is sent, within limits
}
/** The input of a tick: the device's reading, and what the user has done. */
export interface TickOptions {
  sampleTime?: number; sequence?: number;  // when the device was read, default now; its number, default a fresh one
  stop?: boolean; resume?: boolean; restart?: boolean; held?: boolean; disconnected?: boolean;
}

/** A ball or a point that touches a model, with the safety filter before its device. Research software, not a safety device. */
export class Session {
  /** pose: of the tool in the world, m; time: s, monotonic. What is not finite gives zero force and says so. */
  tick(pose: Pose, time: number, options?: TickOptions): Force;
  /** A simulated stylus in a hand that wants to be at targets, one a millisecond; goes on from call to call. */
  simulate(targets: Rows): {positions: Float64Array; forces: Float64Array; depths: Float64Array; tools: Float64Array};
  /** Frees the memory; whatever is called afterwards throws. */
  close(): void;
}

/** Many bodies in one world that move: poses in, complete contacts of all pairs out. */
export class Pile {
  /** The body's number, the lowest that is free. Its model and its probe may be closed afterwards. */
  add(body: Body): number;
  /** Takes a body out; its number is given out again. */
  remove(number: number): void;
  /** Contacts of all pairs that are near each other, in the order of a, then b. poses: of the bodies by their numbers; the others
   *  stay. A body whose pose is not finite is near nothing. near: pairs whose spheres touch. */
  query(poses?: Pose[], options?: ContactOptions): {pairs: PilePair[]; near: number; status: number};
  /** Frees the memory; whatever is called afterwards throws. */
  close(): void;
}

/** The library, once it is loaded. */
export interface Sqmap {
  readonly version: string;
  readonly formatVersion: number;
  /** A model from the bytes of its file. @throws SqmapError */
  open(bytes: Uint8Array | ArrayBuffer): Model;
  /** Bakes triangles; some seconds for ten thousand. @throws SqmapError with the face, vertex or edge and a cure */
  bake(mesh: {vertices: Rows; triangles: Triangles}, options?: BakeOptions): Model;
  /** Bakes a mesh file: OFF, OBJ, STL, PLY, glTF, GLB. name: its ending says which. */
  bakeFile(name: string, bytes: Uint8Array, options?: BakeOptions): Model;
  /** Prepares points that touch models. With the triangles of a closed mesh, as model.mesh has them, it has complete contacts too.
   *  @throws SqmapError with the triangle that is open, turned round or inside out */
  probe(points: Rows, triangles?: Triangles): Probe;
  /** Vertices of each body in the other's model; in one direction alone where the other body has no model. */
  pair(a: Body, b: Body, options?: PairOptions): PairContacts;
  /** Contacts of two closed meshes, none missed: vertices in the other body's model, edges against edges, faces. */
  contacts(a: Body, b: Body, options?: ContactOptions): SurfaceContacts;
  /** The volume that two closed meshes share, exact from their triangles. */
  overlap(a: Body, b: Body): Overlap;
  /** The least distance of two closed meshes. */
  clearance(a: Body, b: Body): Clearance;
  /** True where two bodies are at most so far apart; it stops at the first triangles that are. */
  isWithin(a: Body, b: Body, distance: number): boolean;
  /** The first touch while b moves to a pose, in a straight line and about one axis, and a rests or moves to poseA. time: the share of
   *  the motion that is done by then, never too late; 1 if they do not touch. */
  firstTouch(a: Body, b: Body, pose: Pose, poseA?: Pose): {touches: boolean; time: number; status: number};
  /** When points and triangles first touch that move in straight lines at a steady rate, or with edges, edges and edges. start, end: 12
   *  numbers a row at the times 0 and 1, a point and the triangle's corners, or the ends of one edge, then of the other. time: not after
   *  the first touch; 1 if they do not touch. A coordinate that is not finite touches at time 0. */
  firstTouchFeatures(start: Rows, end: Rows, options?: FeatureOptions): {touches: boolean[]; time: Float64Array};
  /** How far b has to be moved to be free of a: along a direction of three numbers to the first gap; without one the shortest
   *  translation that is known, of convex solids the least of all. */
  separation(a: Body, b: Body, direction?: number[]): Separation;
  /** A pile without bodies. */
  pile(options?: PileOptions): Pile;
  /** A tool that touches a model. @throws SqmapError */
  session(model: Model, options?: SessionOptions): Session;
}

/** Loads the library. wasm: the bytes of sqmap.wasm, where it is not beside index.js. */
export function load(options?: {wasm?: Uint8Array | ArrayBuffer}): Promise<Sqmap>;
