// A small building as an IFC file, in millimetres, with five overlaps whose depths are known and neighbours that have none.

/** Each overlap as the names of both elements, the least translation that parts them, metres, and the litres that both claim. */
export const overlaps = [
  ["Slab A", "Slab B", 0.03, 270],     // one on the other, 30 mm too low
  ["Wall A", "Wall B", 0.05, 25],      // in one line, faces coplanar but for rounding: 30 degrees off the axes
  ["Wall C", "Pipe", 0.5],             // right through: 0.4 m from the wall's middle to the nearer end, 0.1 m more to its face
  ["Column", "Beam", 0.08, 7.2],       // the beam's end in the column
  ["Slab C", "Conduit", 0.07],         // swallowed: its axis 60 mm below the top, its radius 10 mm
];

const turned = (degrees, [x, y, z]) => {
  const [c, s] = [Math.cos((degrees * Math.PI) / 180), Math.sin((degrees * Math.PI) / 180)];
  return [c * x - s * y, s * x + c * y, z];
};

/** type, name, profile (two sides or a radius), length of the extrusion, position of the middle of its first face, its axis, the
 *  direction of the profile's x axis; metres. */
const rotatedWall = (name, x) => ["WALL", name, [3, 0.2], 2.5, turned(30, [x, 10, 0.3]), [0, 0, 1], turned(30, [1, 0, 0])];
const elements = [
  ["SLAB", "Slab A", [6, 4], 0.2, [0, 0, 0]],
  ["SLAB", "Slab B", [6, 4], 0.2, [3, 1, 0.17]],
  ["WALL", "Wall on slab A", [0.2, 3], 2.5, [-2.5, 0, 0.2]],           // stands on it: touches, without depth
  rotatedWall("Wall A", 1.5),
  rotatedWall("Wall B", 4.45),
  rotatedWall("Wall beside B", 7.451),                                 // 1 mm beside it
  ["WALL", "Wall C", [4, 0.2], 2.5, [20, 0, 0]],
  ["PIPESEGMENT", "Pipe", 0.05, 1, [20.3, -0.6, 1.2], [0, 1, 0], [1, 0, 0]],
  ["WALL", "Wall D", [4, 0.2], 2.5, [20, 5, 0], [0, 0, 1], [1, 0, 0], [0.4, 0.4, 0.5, 1]],  // with an opening
  ["PIPESEGMENT", "Pipe in the opening", 0.05, 1, [20.5, 4.5, 1.2], [0, 1, 0], [1, 0, 0]],
  ["COLUMN", "Column", [0.4, 0.4], 3, turned(25, [30, 0, 0]), [0, 0, 1], turned(25, [1, 0, 0])],
  ["BEAM", "Beam", [0.3, 0.3], 2, turned(25, [30.12, 0, 1.5]), turned(25, [1, 0, 0]), [0, 0, 1]],
  ["SLAB", "Slab C", [6, 4], 0.2, [40, 0, 0]],
  ["PIPESEGMENT", "Conduit", 0.01, 1, [39.5, 0.3, 0.14], [1, 0, 0], [0, 0, -1]],
];

/** The file's text. */
export function building() {
  const lines = [], number = (x) => (Number.isInteger(x) ? `${x}.` : String(x)), numbers = (list) => `(${list.map(number).join()})`;
  const add = (text) => `#${lines.push(text)}`;
  const id = () => `'${String(lines.length).padStart(22, "0")}'`;
  const place = (at, axis = [0, 0, 1], x = [1, 0, 0]) => add(`IFCAXIS2PLACEMENT3D(${add(`IFCCARTESIANPOINT(${numbers(at.map((v) => 1000 * v))})`)},${
    add(`IFCDIRECTION(${numbers(axis)})`)},${add(`IFCDIRECTION(${numbers(x)})`)})`);
  const origin = place([0, 0, 0]), up = add("IFCDIRECTION((0.,0.,1.))");
  const context = add(`IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-6,${origin},$)`);
  add(`IFCPROJECT(${id()},$,'Building',$,$,$,$,(${context}),${add(`IFCUNITASSIGNMENT((${add("IFCSIUNIT(*,.LENGTHUNIT.,.MILLI.,.METRE.)")}))`)})`);
  const flat = add(`IFCAXIS2PLACEMENT2D(${add("IFCCARTESIANPOINT((0.,0.))")},$)`);
  const product = (type, name, profile, length, frame) => {
    const area = add(Array.isArray(profile) ? `IFCRECTANGLEPROFILEDEF(.AREA.,$,${flat},${profile.map((v) => number(1000 * v)).join()})`
                                            : `IFCCIRCLEPROFILEDEF(.AREA.,$,${flat},${number(1000 * profile)})`);
    const solid = add(`IFCEXTRUDEDAREASOLID(${area},${origin},${up},${number(1000 * length)})`);
    const shape = add(`IFCPRODUCTDEFINITIONSHAPE($,$,(${add(`IFCSHAPEREPRESENTATION(${context},'Body','SweptSolid',(${solid}))`)}))`);
    return add(`IFC${type}(${id()},$,'${name}',$,$,${add(`IFCLOCALPLACEMENT($,${frame})`)},${shape},$,$)`);
  };
  for (const [type, name, profile, length, at, axis, x, opening] of elements) {
    const built = product(type, name, profile, length, place(at, axis, x));
    if (opening === undefined) continue;
    const [width, height, right, above] = opening;
    const hole = product("OPENINGELEMENT", `Opening of ${name}`, [width, 0.6], height, place([at[0] + right, at[1], at[2] + above]));
    add(`IFCRELVOIDSELEMENT(${id()},$,$,$,${built},${hole})`);
  }
  return `ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('ViewDefinition [CoordinationView]'),'2;1');\nFILE_NAME('building.ifc','',(''),(''),'','','');\n` +
         `FILE_SCHEMA(('IFC4'));\nENDSEC;\nDATA;\n${lines.map((text, i) => `#${i + 1}=${text};\n`).join("")}ENDSEC;\nEND-ISO-10303-21;\n`;
}
