// Layout of sqmap.h's structs in WebAssembly: pointers and sizes of four bytes, every member at a multiple of its own size.

const sizes = {u8: 1, i16: 2, i32: 4, u32: 4, size: 4, pointer: 4, f32: 4, f64: 8, u64: 8};

/** "name:type" or "name:type[count]" for each member; the first is the struct's size, unless told otherwise. */
function layout(text, hasSize = true) {
  const members = {};
  let end = 0, alignment = 1;
  for (const word of (hasSize ? "size:size " : "").concat(text).trim().split(/\s+/)) {
    const [, name, type, count] = word.match(/^(\w+):(\w+)(?:\[(\d+)\])?$/);
    const size = sizes[type];
    alignment = Math.max(alignment, size);
    const offset = Math.ceil(end / size) * size;
    members[name] = {offset, type, count: count === undefined ? undefined : Number(count)};
    end = offset + size * Number(count ?? 1);
  }
  return {members, bytes: Math.ceil(end / alignment) * alignment};
}

export const structs = {
  error: layout("code:i32 name:pointer element:pointer message:pointer cure:pointer"),
  text: layout("text:pointer capacity:size needed:size words:i32"),
  mesh: layout("vertices:pointer vertexCount:size triangles:pointer triangleCount:size"),
  bakeOptions: layout(`targetError:f64 band:f64 thickness:f64 maxParts:u32 projection:i32 repair:i32 acceptsSurface:i32
    withoutExact:i32 threads:u32 progress:pointer progressContext:pointer source:pointer words:i32 withoutInput:i32
    unit:f64 gap:f64 wrapTolerance:f64 solid:i32 paper:pointer withoutLocator:i32`),
  facts: layout(`rMax:f64 band:f64 centre:f64[3] radius:f64 bytes:u64 parts:u32 vertices:u32 triangles:u32 isSolid:i32
    hasExact:i32 isNormal:i32 isDoubtful:i32 hasInput:i32 cure:i32`),
  queryOptions: layout(`layer:i32 threads:u32 tolerance:f64 margin:f64 band:f64 isSmooth:i32 isFirstOnly:i32 gate:u32
    hasOffset:i32 projector:i32 nearestSteps:i32 withoutGaps:i32 withoutPruning:i32`),
  points: layout("xyz:pointer count:size pose:pointer"),
  contacts: layout("contact:pointer depth:pointer normal:pointer closest:pointer part:pointer certain:pointer status:pointer contacts:size"),
  distances: layout("distance:pointer gradient:pointer closest:pointer part:pointer known:pointer status:pointer triangle:pointer"),
  closest: layout("closest:pointer distance:pointer triangle:pointer"),
  bodies: layout(`modelA:u64 probeA:u64 poseA:pointer modelB:u64 probeB:u64 poseB:pointer`),
  body: layout("model:u64 probe:u64 pose:pointer", false),
  pairContact: layout(`onA:f64[3] onB:f64[3] normal:f32[3] depth:f32 index:u32 part:i16 vertexOf:u8 certain:u8 isMutual:u8
    status:u8`, false),
  pairList: layout("contacts:pointer count:size found:size status:u32 edgeLength:f64"),
  contactOptions: layout("perRegion:u32 isFirstOnly:i32"),
  surfaceContact: layout(`onA:f64[3] onB:f64[3] normal:f32[3] depth:f32 featureA:u8 featureB:u8 indexA:u32 indexB:u32 region:u32
    partA:i16 partB:i16 certain:u8 status:u8`, false),
  surfaceList: layout("contacts:pointer count:size found:size meetings:size regions:size status:u32"),
  touch: layout("time:f64 touches:i32 status:u32 endPoseA:pointer"),
  movingFeatures: layout("start:pointer end:pointer count:size areEdges:i32 separation:f64"),
  touches: layout("time:pointer touches:pointer"),
  clearance: layout(`within:f64 distance:f64 atLeast:f64 onA:f64[3] onB:f64[3] triangleA:u32 triangleB:u32 isWithin:i32 status:u32`),
  overlap: layout("volume:f64 error:f64 status:u32"),
  separation: layout("along:f64[3] distance:f64 atLeast:f64 direction:f64[3] isExact:i32 status:u32"),
  pileStep: layout("pose:pointer count:size threads:u32 perRegion:u32 isFirstOnly:i32"),
  pilePair: layout("a:u32 b:u32 first:size count:size found:size meetings:size regions:size status:u8", false),
  pileContacts: layout("pairs:pointer contacts:pointer pairCount:size count:size near:size status:u32"),
  contact: layout("point:f32[3] normal:f32[3] depth:f32 index:u32 part:i16 certain:u8 status:u8", false),
  contactList: layout("contacts:pointer capacity:size found:size anchor:f64[3] status:u32"),
  sessionOptions: layout(`metresPerUnit:f64 pose:pointer radius:f64 stiffness:f64 damping:f64 friction:f64 layer:i32 maxForce:f64
    maxTorque:f64 continuousForce:f64 forceLimit:f64 torqueLimit:f64 hasDeadMan:i32 sidePath:f64 mode:i32 force:i32
    frictionLaw:i32 fC:f64 kF:f64 projector:i32 gate:u32 nearestSteps:i32 withoutGaps:i32 withoutPruning:i32 hasOffset:i32 tool:u64
    withoutEdges:i32 zone:f64`),
  tick: layout("time:f64 sampleTime:f64 sequence:u64 pose:f64[12] acts:u32"),
  force: layout(`force:f64[3] torque:f64[3] commanded:f64[3] depth:f64 normal:f64[3] status:u32 acted:u32 faults:u32
    isEngaged:i32 tool:f64[12]`),
  simulation: layout("targets:pointer count:size positions:pointer forces:pointer depths:pointer tools:pointer"),
};

const getters = {
  u8: (v, at) => v.getUint8(at), i16: (v, at) => v.getInt16(at, true), i32: (v, at) => v.getInt32(at, true),
  u32: (v, at) => v.getUint32(at, true), size: (v, at) => v.getUint32(at, true), pointer: (v, at) => v.getUint32(at, true),
  f32: (v, at) => v.getFloat32(at, true), f64: (v, at) => v.getFloat64(at, true), u64: (v, at) => v.getBigUint64(at, true),
};
const setters = {
  i32: (v, at, x) => v.setInt32(at, x, true), u32: (v, at, x) => v.setUint32(at, x, true),
  size: (v, at, x) => v.setUint32(at, x, true), pointer: (v, at, x) => v.setUint32(at, x, true),
  f64: (v, at, x) => v.setFloat64(at, x, true), u64: (v, at, x) => v.setBigUint64(at, x, true),
};

/** One member of a struct at an address. */
export function read(view, struct, address, name) {
  const {offset, type, count} = struct.members[name];
  if (count === undefined) return getters[type](view, address + offset);
  return Array.from({length: count}, (_, i) => getters[type](view, address + offset + i * sizes[type]));
}

/** Sets the struct's size and the members that are given; what is not given stays zero. */
export function write(view, struct, address, values) {
  for (let i = 0; i < struct.bytes; ++i) view.setUint8(address + i, 0);
  if (struct.members.size?.offset === 0) view.setUint32(address, struct.bytes, true);
  for (const [name, value] of Object.entries(values)) {
    const {offset, type, count} = struct.members[name];
    for (let i = 0; i < (count ?? 1); ++i)
      setters[type](view, address + offset + i * sizes[type], count === undefined ? value : value[i]);
  }
}
