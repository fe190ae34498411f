// The messages between the page and the program, as types: JSON as the program writes it, and the binary stream as it is read here.
/// How tightly the bounds hold a part, or their union the whole; null of a paper model and of edited parts. Lengths: the file's units.
export interface Bound {
  volume: number;
  volume_ratio: number | null;
  support_excess: number;
  support_excess_percent: number;
}
export interface Bounds {
  solid_volume: number;
  superquadric: Bound;
  polytope: Bound;
  both: Bound;
  standard_error: number;
}
export interface Part {
  name: string;
  sphere: number[];
  neighbours: number[];
  triangles: number;
  area: number;
  certified: boolean;
  largestF: number | null;
  a: number[];
  eps: number[];
  taper: number[];
  bend: number;
  bounds: Bounds | null;
}
export type Up = 'x' | 'y' | 'z';
/// loading: objects that are still to come; removed: the name of the object that can be taken back.
export interface Scene {
  objects: ObjectFacts[];
  loading: number;
  removed: string | null;
}
export interface ObjectFacts {
  name: string;
  hash: string;
  sphere: number[];
  namesKept: boolean;
  edited: boolean;
  solid: boolean;
  triangles: number;
  vertices: number;
  hasTriangles: boolean;
  bytes: Record<string, number>;
  rMax: number;
  metresPerUnit: number;
  central: boolean;
  exact: boolean;
  position: number[];
  half: number[];
  centre: number[]; ///< of its box, in the file's coordinates; it stands at position
  up: Up; ///< the file's axis that points upwards
  hidden: boolean; ///< neither seen nor touched
  measured: Record<string, number>;
  parts: Part[];
  bounds: Bounds | null;
  verdict: string;
  notes: string[];
  cure: Cure | null;
  twin: number | null; ///< index of the object of the same mesh and the other projection
  upload: number; ///< the number that the page gave to the object's file; 0: none
  id: number;
  revision: number;
  canUndo: boolean;
  canRedo: boolean;
}
export interface Settings {
  layer: string;
  tolerance: number;
  paperForce: boolean;
  proxy: boolean;
  stiffness: number;
  damping: number;
  law: string;
  friction: number;
  fC: number;
  kF: number;
  texture: number;
  smoothing: number;
  toolRadius: number;
  zone: number;
  forceLimit: number;
  projector: string;
  nearestSteps: number;
  gaps: boolean;
  pruning: boolean;
  gate: number;
  offset: boolean; ///< of the paper's maps
  tool: string | number;
  toolSize: number;
  toolTurn: number;
  toolTilt: number;
  edges: boolean; ///< of a hand or a mesh touch too
}
export interface Worn {
  garment: string;
  fabric: string;
  walks: boolean;
  pinned: number;
  number: number;
  seams: { name: string; sewn: boolean }[];
}
export interface DeviceRow {
  name: string;
  here: boolean;
  state: string;
  rate: number;
  limit: number;
}
export interface Status {
  program: string; ///< a new one after every start
  touching: boolean;
  stopped: boolean;
  device: number;
  devices: DeviceRow[];
  settings: Settings;
  nearestSteps: [number, number]; ///< the range of this setting
  cloth: { here: boolean; worn: Worn | null };
  toolRevision: number;
  recorded?: number; ///< ticks of the recording that the program keeps
  counters?: Record<string, number>;
  limit?: number;
  safeStiffness?: number;
  deviceName?: string;
}
export interface Frame {
  tool: number[];
  hand: number[];
  turn: number[];
  force: number[];
  torque: number[];
  point: number[];
  normal: number[];
  depth: number;
  contacts: number;
  object: number;
  part: number;
  acted: number;
  faults: number;
  late: number;
  degraded: boolean;
  engaged: boolean;
  connected: boolean;
  time: number; ///< of its first tick, by the servo's clock, s
  ticks: Float32Array; ///< TICK numbers each: force, torque, depth, CPU time, s since the first
  recorded: number; ///< ticks that the program has recorded, these included; 0: it does not record
}
export interface ClothFrame {
  status: number;
  speed: number;
  stepMs: number;
  tension: number[];
  body: number[];
  fastest: number;
  contacts: number;
  gap: number;
  pinned: number;
  held: boolean;
  number: number;
  poses: Float32Array; ///< 12 a bone: rows of the rotation, then the shift
  positions: Float32Array; ///< 3 a vertex
}
/// Contacts of the tool with an object, at positions on the maps of its parts.
export interface Feet {
  object: number;
  feet: { part: number; x: number; y: number; depth: number }[];
}
export interface Cure {
  rung: string;
  input_to_result: Record<string, number>;
  result_to_input: Record<string, number>;
  made_up_share: number;
}
/// upload: as in ObjectFacts.
export interface Progress {
  name: string;
  stage: string;
  done: number;
  upload: number;
}
export interface Verdict {
  accepted: boolean;
  verdict: string;
  code?: string;
  element?: string;
  message?: string;
  cure?: string;
  notes?: string[];
  triangles?: number;
}
/// Options for reading a file; an empty one leaves the choice to the program. upload: the number by which the page can cancel it.
export interface Reading {
  repair: string;
  thickness: string;
  unit: string;
  projection: string;
  upload: string;
}
