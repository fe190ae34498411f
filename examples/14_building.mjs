// Lists what clashes in a building: each pair of elements that overlap, with the least translation that parts them and the volume
// that both claim. usage: node 14_building.mjs FILE.ifc [TOLERANCE in metres]       npm install web-ifc sqmap-0.2.0.tgz
import {readFileSync} from "node:fs";
import {load, SqmapError} from "sqmap";
import {IfcAPI} from "web-ifc";

const [file, tolerance = 0.001] = process.argv.slice(2);
function stop(why) {
  console.error(why);
  process.exit(1);
}
if (file === undefined || !(Number(tolerance) >= 0)) stop("usage: node 14_building.mjs FILE.ifc [TOLERANCE in metres]");
const sqmap = await load(), ifc = new IfcAPI();
await ifc.Init();
let building = -1, fault = "it has no elements";
try {
  building = ifc.OpenModel(readFileSync(file));
} catch (error) {
  fault = error.message;
}
if (building < 0) stop(`${file} cannot be read as IFC: ${fault}`);

/** The triangles of an element, in metres. */
function meshOf({geometries}) {
  const vertices = [], triangles = [];
  for (let i = 0; i < geometries.size(); ++i) {
    const {geometryExpressID, flatTransformation: m} = geometries.get(i), geometry = ifc.GetGeometry(building, geometryExpressID);
    const rows = ifc.GetVertexArray(geometry.GetVertexData(), geometry.GetVertexDataSize());  // position and normal
    const corners = ifc.GetIndexArray(geometry.GetIndexData(), geometry.GetIndexDataSize()), first = vertices.length;
    for (let r = 0; r < rows.length; r += 6)
      vertices.push([0, 1, 2].map((k) => m[k] * rows[r] + m[4 + k] * rows[r + 1] + m[8 + k] * rows[r + 2] + m[12 + k]));
    for (let t = 0; t < corners.length; t += 3) triangles.push([0, 1, 2].map((k) => first + corners[t + k]));
    geometry.delete();
  }
  return {vertices, triangles};
}

const pile = sqmap.pile(), elements = [];
ifc.StreamAllMeshes(building, (element) => {
  const name = ifc.GetLine(building, element.expressID).Name?.value ?? `#${element.expressID}`;
  try {
    const model = sqmap.bake(meshOf(element), {maxParts: 1}), {vertices, triangles} = model.mesh;
    const body = {model, probe: sqmap.probe(vertices, triangles)};
    elements[pile.add(body)] = {name, body};
  } catch (error) {
    if (!(error instanceof SqmapError)) throw error;
    console.error(`${name} is left out: ${error.message}`);
  }
});

let clashes = 0;
for (const {a, b} of pile.query(undefined, {firstOnly: true}).pairs) {
  const [first, second] = [elements[a], elements[b]], {distance, atLeast, isExact} = sqmap.separation(first.body, second.body);
  if (distance <= tolerance) continue;  // they touch, as a wall does that stands on a slab
  const {volume} = sqmap.overlap(first.body, second.body), millimetres = (metres) => (1000 * metres).toFixed(4);
  const depth = isExact ? `${millimetres(distance)} mm` : `${millimetres(atLeast)} to ${millimetres(distance)} mm`;
  console.log(`${first.name} in ${second.name}: ${depth} deep, ${(1000 * volume).toFixed(3)} litres`);
  ++clashes;
}
console.log(`${clashes} clashes of ${elements.length} elements`);
