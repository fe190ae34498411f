// The npm package: what it answers, and what it says of bad input. Prints the number of checks.
// usage: node package_test.mjs PACKAGE
import assert from "node:assert/strict";
import {resolve} from "node:path";
import {pathToFileURL} from "node:url";

const {load, SqmapError} = await import(pathToFileURL(resolve(process.argv[2], "index.js")));
const sqmap = await load();

/** A box from -1 to 1, each side of n x n squares. */
function box(n) {
  const vertices = [], triangles = [], numbers = new Map();
  const vertex = (p) => {
    const key = p.join();
    if (!numbers.has(key)) {
      numbers.set(key, vertices.length);
      vertices.push(p);
    }
    return numbers.get(key);
  };
  for (let axis = 0; axis < 3; ++axis)
    for (const side of [-1, 1])
      for (let i = 0; i < n; ++i)
        for (let j = 0; j < n; ++j) {
          const at = (u, v) => {
            const p = [0, 0, 0];
            p[axis] = side;
            p[(axis + 1) % 3] = (2 * (i + u)) / n - 1;
            p[(axis + 2) % 3] = (2 * (j + v)) / n - 1;
            return vertex(p);
          };
          const [a, b, c, d] = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
          triangles.push(...(side > 0 ? [[a, b, c], [a, c, d]] : [[a, c, b], [a, d, c]]));
        }
  return {vertices, triangles};
}

let checks = 0;
function check(name, action) {
  action();
  ++checks;
}
function refuses(name, code, element, action) {
  check(name, () => assert.throws(action, (e) => {
    assert.ok(e instanceof SqmapError, `${name}: ${e}`);
    assert.equal(e.name, code);
    assert.match(e.element, element);
    assert.ok(e.cure.length > 0);
    return true;
  }));
}

const stages = [];
const model = sqmap.bake(box(6), {source: "box", progress: (stage) => void stages.push(stage)});
check("facts", () => {
  const facts = model.facts;
  assert.ok(facts.isSolid && facts.hasExact && !facts.isNormal);
  assert.ok(Math.abs(facts.rMax - Math.sqrt(12)) < 1e-6);
  assert.equal(facts.triangles, 6 * 36 * 2);
  assert.equal(facts.bytes, model.toBytes().length);
});
check("progress", () => assert.ok(stages.length > 3));
check("info", () => assert.equal(model.info.parts.length, model.facts.parts));
check("points", () => {
  const a = model.query([[0, 0, 0.9], [0, 0, 1.1], [0.5, 0, -0.99]], {layer: "exact"});
  assert.deepEqual([...a.contact], [1, 0, 1]);
  assert.ok(Math.abs(a.depth[0] - 0.1) < 1e-6 && Math.abs(a.normal[2] - 1) < 1e-6 && Math.abs(a.depth[2] - 0.01) < 1e-6);
  assert.equal(a.contacts, 2);
});
check("distances on both sides", () => {
  const d = model.distances([0, 0, 0.9, 0, 0, 3, 2, 2, 1]);
  assert.ok(Math.abs(d.distance[0] + 0.1) < 1e-6 && Math.abs(d.distance[1] - 2) < 1e-6);
  assert.ok(Math.abs(d.distance[2] - Math.SQRT2) < 1e-6);
});
check("a pose moves the model", () => {
  const pose = [1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
  assert.deepEqual([...model.query([5, 0, 0.9, 0, 0, 0.9], {pose}).contact], [1, 0]);
});
check("closest points", () => {
  const c = model.closestPoints([[3, 0, 0]]);
  assert.ok(Math.abs(c.distance[0] - 2) < 1e-6 && Math.abs(c.closest[0] - 1) < 1e-6);
});
check("face centres and contacts name what was given: as given, reordered, each face with corners of its own, vertices reordered", () => {
  const round = (p, r) => p.map((x) => (x * r) / Math.hypot(...p)), turned = ([x, y, z], a) => [x * Math.cos(a) - y * Math.sin(a), x * Math.sin(a) + y * Math.cos(a), z];
  const bends = [(p) => p, (p) => round(p, 1), (p) => round(p, 1e-3), ([x, y, z]) => [3 * x, y, z / 2], ([x, y, z]) => [x + z / 2, y, z],
                 (p) => turned(p, p[2] / 3), ([x, y, z]) => [x * (1.5 + z / 2), y, z], ([x, y, z]) => [x + 100, y - 300, z + 7],
                 (p) => round(p, 1 + p[2] / 4), ([x, y, z]) => [x, y, z + (x * x) / 3]];
  let state = 1, named = 0, touched = 0;
  const random = (n) => (state = (state * 48271) % 2147483647) % n;
  const permutation = (n) => Array.from({length: n}, (_, i) => [random(1e9), i]).sort(([a], [b]) => a - b).map(([, i]) => i);
  for (const bend of bends) {
    const {vertices, triangles} = box(2), at = vertices.map(bend), order = permutation(at.length);
    const moved = [];
    order.forEach((to, from) => (moved[to] = at[from]));
    const forms = [{vertices: at, triangles},
                   {vertices: at, triangles: permutation(triangles.length).map((i) => [...triangles[i].slice(i % 3), ...triangles[i].slice(0, i % 3)])},
                   {vertices: triangles.flatMap((t) => t.map((i) => at[i])), triangles: triangles.map((_, i) => [3 * i, 3 * i + 1, 3 * i + 2])},
                   {vertices: moved, triangles: triangles.map((t) => t.map((i) => order[i]))}];
    for (const given of forms) {
      const model = sqmap.bake(given), {sources, mesh} = model;
      const centres = given.triangles.map((t) => [0, 1, 2].map((k) => (given.vertices[t[0]][k] + given.vertices[t[1]][k] + given.vertices[t[2]][k]) / 3));
      for (const {triangle} of [model.distances(centres), model.closestPoints(centres)])
        triangle.forEach((found, i) => assert.equal(sources.triangles[found], i));
      sources.vertices.forEach((own, v) => assert.deepEqual([...mesh.vertices.slice(3 * v, 3 * v + 3)], given.vertices[own]));
      named += centres.length;
      const size = model.facts.rMax, step = [0.011, 0.017, 0.007].map((x) => x * size), probe = sqmap.probe(mesh.vertices);
      const {contacts} = model.probe(probe, {layer: "exact", probePose: [1, 0, 0, step[0], 0, 1, 0, step[1], 0, 0, 1, step[2], 0, 0, 0, 1]});
      for (const {index, point, depth} of contacts) {
        const own = given.vertices[sources.vertices[index]];
        assert.ok(Math.abs(Math.hypot(...[0, 1, 2].map((k) => own[k] + step[k] - point[k])) - depth) < 1e-5 * size);
      }
      touched += contacts.length;
      probe.close();
      model.close();
    }
  }
  assert.equal(named, 10 * 4 * 48);
  assert.ok(touched > 200, `${touched} contacts`);
});
check("bytes and back", () => {
  const again = sqmap.open(model.toBytes());
  const points = Float64Array.from({length: 3000}, (_, i) => Math.sin(i * 12.9898) * 1.2);
  assert.deepEqual(again.query(points), model.query(points));
  again.close();
});
check("probe", () => {
  const probe = sqmap.probe([[0, 0, 0], [0, 0, 0.2], [0, 0, 3]]);
  const found = model.probe(probe, {probePose: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0.9, 0, 0, 0, 1]});
  assert.equal(found.found, 1);
  assert.equal(found.contacts[0].index, 0);
  assert.ok(Math.abs(found.contacts[0].depth - 0.1) < 1e-3 && Math.abs(found.contacts[0].point[2] - 1) < 1e-3);
  probe.close();
});
check("the same bytes twice", () => {
  const a = sqmap.bake(box(6), {source: "box"});
  assert.deepEqual(a.toBytes(), model.toBytes());
  a.close();
});
check("a session pushes out with its stiffness, once it was free", () => {
  const session = sqmap.session(model, {stiffness: 300, layer: "exact"});
  const targets = Array.from({length: 1500}, (_, i) => [0, 0, i < 100 ? 1.01 : 0.998]);
  const {positions, forces, depths} = session.simulate(targets);
  const last = targets.length - 1, depth = 1 - positions[3 * last + 2];
  assert.ok(depth > 1e-4 && Math.abs(depths[last] - depth) < 1e-5);
  assert.ok(Math.abs(forces[3 * last + 2] - 300 * depth) < 0.02 * 300 * depth);
  const again = sqmap.session(model, {stiffness: 300, layer: "exact"});
  assert.deepEqual(again.simulate(targets).forces, forces);
  const pose = (z) => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, z, 0, 0, 0, 1];
  again.tick(pose(1.01), 2);
  const tick = again.tick(pose(NaN), 2.001);
  assert.ok(tick.force.every((x) => x === 0) && (tick.status & 4) !== 0);
  assert.ok(again.tick(pose(1.01), 2.002, {stop: true}).faults !== 0);
  session.close();
  again.close();
  assert.throws(() => again.tick(pose(1), 3), SqmapError);
});

check("a proxy stays on the surface while the device is pressed in", () => {
  const session = sqmap.session(model, {mode: "proxy", sidePath: 0.005, layer: "exact", friction: 0});
  const targets = Array.from({length: 1500}, (_, i) => [0, 0, i < 100 ? 1.01 : 0.997]);
  const {positions, tools} = session.simulate(targets), z = 3 * (targets.length - 1) + 2;
  assert.ok(Math.abs(tools[z] - 1) < 3e-4 && tools[z] - positions[z] > 5e-4);
  const {tool} = session.tick([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, positions[z], 0, 0, 0, 1], 1.501);
  assert.ok(tool.length === 16 && tool[15] === 1 && Math.abs(tool[11] - 1) < 3e-4);
  session.close();
});

const shifted = (x, y, z) => [1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z, 0, 0, 0, 1];
const near = (found, expected, error = 1e-9) => assert.ok(Math.abs(found - expected) <= error, `${found}, not ${expected}`);
const ball = (() => {
  const {vertices, triangles} = box(8);
  return {triangles, vertices: vertices.map((p) => p.map((x, k) => ((k === 0 ? 1.3 : 1) * x) / Math.hypot(...p)))};
})();
const paper = sqmap.bake(ball, {projection: "normal"}), inner = ball.vertices.map((p) => p.map((x) => 0.9 * x));
check("a paper model is read as its options say", () => {
  const plain = paper.query(inner), depths = (options) => [...paper.query(inner, options).depth];
  assert.ok(paper.facts.isNormal && plain.contacts === inner.length);
  inner.forEach((_, i) => near(plain.depth[i], 0.115, 0.03));  // 0.1 about its waist, 0.13 at its tips
  assert.deepEqual(depths({projector: "newton", gate: 10, nearestSteps: 2, gaps: true, pruning: true, offset: false}), [...plain.depth]);
  for (const options of [{projector: "printed"}, {projector: "pyramid"}, {nearestSteps: 0}, {offset: true}]) {
    const found = depths(options);
    assert.ok(found.some((d, i) => d !== plain.depth[i]), JSON.stringify(options));
  }
  assert.deepEqual(depths({layer: "gate", gate: 1e9}), [...plain.depth]);  // every base map is sparse beside that
  assert.deepEqual(depths({layer: "gate", gate: 1}), depths({layer: 2}));
  const probe = sqmap.probe(inner), last = (options) => paper.probe(probe, options).contacts.map((c) => c.depth);
  assert.ok(last({projector: "printed"}).some((d, i) => d !== last({})[i]));
  const claims = (options) => paper.query(ball.vertices, {pose: shifted(0.02, 0.01, 0), ...options}).contacts;
  assert.ok(claims({pruning: false}) >= claims({}) && claims({gaps: false}) >= claims({}));
  probe.close();
});
check("the paper's force is felt by a point, a ball and a tool, within its zone", () => {
  const force = {force: "paper", stiffness: 300, frictionLaw: "none", maxForce: 3, forceLimit: 3}, at = shifted(0, 0, 0.998);
  const felt = (options) => {
    const session = sqmap.session(paper, {...force, ...options}), {commanded} = session.tick(at, 0.001);
    session.close();
    return commanded[2];
  };
  const point = felt({}), printed = felt({projector: "printed"});
  near(point, 300 * 0.002, 0.3);
  assert.notEqual(printed, point);
  assert.notEqual(felt({radius: 0.05, zone: 0.051}), felt({radius: 0.05}));  // weights fall towards the sphere's surface
  const tool = sqmap.probe(box(2).vertices.map((p) => p.map((x) => 0.02 * x)), box(2).triangles);
  const whole = felt({tool, edges: false}), middle = felt({tool, edges: false, zone: 0.021});  // the middles of the tool's sides alone
  assert.ok(whole > 0 && middle > 0 && middle !== whole, `${whole}, ${middle}`);
  const rubs = sqmap.session(paper, {...force, frictionLaw: "paper", fC: 0.5, kF: 0});
  rubs.tick(at, 0.001);
  const {commanded} = rubs.tick(shifted(1e-4, 0, 0.998), 0.002);
  near(commanded[0], -0.5, 0.05);
  rubs.close();
  tool.close();
});
refuses("a gate where there is none", "E_ARGUMENT", /^options\.gate$/, () => paper.query(inner, {gate: 20}));
refuses("a projector of a central model", "E_ARGUMENT", /^options\.projector$/, () => model.query(inner, {projector: "printed"}));
refuses("gaps on layer 2", "E_ARGUMENT", /^options\.gaps$/, () => paper.query(inner, {layer: 2, gaps: false}));
refuses("pruning of a central model", "E_ARGUMENT", /^options\.pruning$/, () => model.query(inner, {pruning: false}));
refuses("a zone of a point", "E_ARGUMENT", /^options\.zone$/, () => sqmap.session(paper, {zone: 0.01}));
refuses("the paper's force of a central model", "E_ARGUMENT", /^options\.force$/, () => sqmap.session(model, {force: "paper"}));
refuses("a tool of points alone", "E_MISSING", /^options\.tool$|^tool$/, () => sqmap.session(model, {tool: sqmap.probe(inner)}));
paper.close();

/** A bar of 6 x 1 x 1 along axis 0 or 1, stood on one of its long edges: another is its ridge, at a height of sqrt(1/2). */
function barMesh(axis) {
  const {vertices, triangles} = box(1), c = Math.SQRT1_2;
  return {triangles, vertices: vertices.map(([x, y, z]) => {
    const across = (c * (y - z)) / 2, up = (c * (y + z)) / 2;
    return axis === 0 ? [3 * x, across, up] : [-across, 3 * x, up];
  })};
}
function bar(axis) {
  const {vertices, triangles} = barMesh(axis);
  return sqmap.probe(vertices, triangles);
}
check("ridges that cross have a contact, edge on edge, with its witness points", () => {
  const a = {probe: bar(0)}, b = {probe: bar(1), pose: shifted(0.3, 0.2, 2 * Math.SQRT1_2 - 0.01)};
  const {contacts, found, meetings, regions, status} = sqmap.contacts(a, b);
  assert.deepEqual([contacts.length, found, regions, status], [1, 1, 1, 0]);
  assert.ok(meetings >= 4);
  const [c] = contacts;
  assert.deepEqual([c.featureA, c.featureB, c.partA, c.partB, c.region], ["edge", "edge", -1, -1, 0]);
  near(c.depth, 0.01, 1e-8);
  [0.3, 0, Math.SQRT1_2].forEach((x, k) => near(c.onA[k], x));
  [0.3, 0, Math.SQRT1_2 - 0.01].forEach((x, k) => near(c.onB[k], x));
  [0, 0, 1].forEach((x, k) => near(c.normal[k], x, 1e-7));
  near(sqmap.separation(a, b, [0, 0, 2]).distance, 0.01);
  assert.equal(sqmap.contacts(a, {...b, pose: shifted(0.3, 0.2, 2 * Math.SQRT1_2 + 1e-9)}).contacts.length, 0);
});
check("vertices of a pair are found on both sides, and the result says which edges cannot be missed", () => {
  const probe = sqmap.probe(model.mesh.vertices), a = {model, probe}, b = {model, probe, pose: shifted(0.03, 0.05, 1.96)};
  const found = sqmap.pair(a, b, {layer: "exact"});
  assert.deepEqual([found.status, found.edgeLength], [0, 0]);
  assert.deepEqual(new Set(found.contacts.map((c) => c.vertexOf)), new Set(["a", "b"]));
  for (const {onA, onB, normal, depth, index, vertexOf} of found.contacts) {
    onB.forEach((x, k) => near(x, onA[k] - depth * normal[k], 1e-6));
    const own = [...model.mesh.vertices.slice(3 * index, 3 * index + 3)];
    (vertexOf === "a" ? onA : onB).forEach((x, k) => near(x, own[k] + (vertexOf === "a" ? 0 : b.pose[4 * k + 3]), 1e-6));
  }
  near(Math.max(...found.contacts.map((c) => c.depth)), 0.04, 1e-6);
  assert.ok(found.found >= found.contacts.length && sqmap.pair(a, b, {firstOnly: true}).found < found.found);
  const {found: one} = sqmap.pair({probe}, b, {layer: "exact"}), {found: other} = sqmap.pair(a, {probe, pose: b.pose}, {layer: "exact"});
  assert.deepEqual([one > 0, other > 0, one + other], [true, true, found.found]);
  const apart = {...b, pose: shifted(0.03, 0.05, 2.1)}, {contacts, edgeLength} = sqmap.pair(a, apart, {margin: 0.2});
  assert.equal(sqmap.pair(a, apart).contacts.length, 0);
  assert.ok(contacts.length > 0 && edgeLength > 0.3999 && edgeLength < 0.4, `${edgeLength}`);
  probe.close();
});
check("a margin of half the longest edge finds ridges that cross between their vertices", () => {
  const barAt = (axis, pose) => {
    const model = sqmap.bake(barMesh(axis));
    return {model, probe: sqmap.probe(model.mesh.vertices), pose};
  };
  const a = barAt(0), b = barAt(1, shifted(0.3, 0.2, 2 * Math.SQRT1_2 - 0.01));
  assert.equal(sqmap.pair(a, b, {layer: "exact"}).found, 0);
  const {found, edgeLength} = sqmap.pair(a, b, {layer: "exact", margin: 3.1});  // edges are at most 6.08 long
  assert.ok(found > 0 && edgeLength > 6.1, `${found} contacts, ${edgeLength}`);
});
const cube = {model, probe: sqmap.probe(model.mesh.vertices, model.mesh.triangles)}, cubeAt = (...at) => ({...cube, pose: shifted(...at)});
check("a probe counts its points and triangles", () => assert.deepEqual([cube.probe.count, cube.probe.triangles], [218, 432]));
check("a region keeps as many contacts as were asked for, the deepest among them", () => {
  const b = cubeAt(0.013, 0.017, 1.96), all = sqmap.contacts(cube, b), few = sqmap.contacts(cube, b, {perRegion: 4});
  const deepest = ({contacts}) => Math.max(...contacts.map((c) => c.depth));
  assert.deepEqual([few.contacts.length, few.regions, few.found > 4, all.regions], [4, 1, true, 1]);
  near(deepest(few), deepest(all));
  near(deepest(few), 0.04, 1e-6);
  assert.ok(few.contacts.every((c) => c.region === 0 && c.partA >= 0 && c.partB >= 0));
  assert.equal(sqmap.contacts(cube, b, {firstOnly: true}).contacts.length, 1);
});
check("there is space for however many contacts there are", () => {
  const {vertices, triangles} = box(24), fine = {probe: sqmap.probe(vertices, triangles)}, above = {...fine, pose: shifted(0, 0, 2)};
  const found = sqmap.contacts(fine, above);
  assert.ok(found.meetings > 4096 && found.status === 0 && found.regions === 1, JSON.stringify({...found, contacts: []}));
  const pile = sqmap.pile({contacts: 16});
  pile.add(fine);
  pile.add(above);
  assert.deepEqual(pile.query().pairs.map((pair) => [pair.meetings, pair.found, pair.status]), [[found.meetings, found.found, 0]]);
  pile.close();
});
check("what two boxes share, their distance, their first touch and what separates them are those of boxes", () => {
  const overlap = sqmap.overlap(cube, cubeAt(1.5, 1.5, 1.5));
  near(overlap.volume, 0.125, 1e-9 + overlap.error);
  const {distance, atLeast, onA, onB, triangleA} = sqmap.clearance(cube, cubeAt(3, 0.25, 0));
  near(distance, 1, 1e-12);
  assert.ok(atLeast <= 1 && atLeast > 1 - 1e-12 && triangleA >= 0 && onA[0] === 1 && onB[0] === 2 && onA[1] === onB[1]);
  assert.ok(sqmap.isWithin(cube, cubeAt(3, 0, 0), 1.0001) && !sqmap.isWithin(cube, cubeAt(3, 0, 0), 0.9999));
  assert.ok(sqmap.isWithin(cube, cubeAt(1.9, 0, 0), 0) && !sqmap.isWithin(cube, cubeAt(2.1, 0, 0), 0));
  const {touches, time} = sqmap.firstTouch(cube, cubeAt(5, 0.1, 0.2), shifted(1, 0.1, 0.2));
  assert.ok(touches && time <= 0.75 && time > 0.749);
  assert.deepEqual(sqmap.firstTouch(cube, cubeAt(5, 0, 0), shifted(5, 9, 0)), {touches: false, time: 1, status: 0});
  assert.ok(sqmap.firstTouch(cube, cubeAt(5, 0.1, 0.2), shifted(3, 0.1, 0.2), shifted(2, 0, 0)).time <= 0.75);
  assert.ok(!sqmap.firstTouch(cube, cubeAt(5, 0.1, 0.2), shifted(3, 0.1, 0.2), shifted(0.5, 0, 0)).touches);
  const still = [0, 0, 0, 4, 0, 0, 0, 4, 0], falls = (from, to) => [[[1, 1, from, ...still], [5, 5, from, ...still]], [[1, 1, to, ...still], [5, 5, to, ...still]]];
  const passes = sqmap.firstTouchFeatures(...falls(1, -3));
  assert.deepEqual([passes.touches, passes.time[1]], [[true, false], 1]);
  near(passes.time[0], 0.25, 1e-8);
  near(sqmap.firstTouchFeatures(...falls(1, -3), {separation: 0.5}).time[0], 0.125, 1e-8);
  const edges = sqmap.firstTouchFeatures([[-1, 0, 1, 1, 0, 1, 0, -1, 0, 0, 1, 0]], [[-1, 0, -1, 1, 0, -1, 0, -1, 0, 0, 1, 0]], {edges: true});
  assert.ok(edges.touches[0] && edges.time[0] <= 0.5);
  near(edges.time[0], 0.5, 1e-8);
  assert.throws(() => sqmap.firstTouchFeatures(...falls(1, 0), {separation: -1}), (e) => e.element === "options.separation");
  assert.throws(() => sqmap.firstTouchFeatures([[1, 2]], [[1, 2]]), (e) => e.element === "start[0]");
  near(sqmap.separation(cube, cubeAt(1.5, 0.1, 0), [4, 0, 0]).distance, 0.5, 1e-8);
  const least = sqmap.separation(cube, cubeAt(0.2, 1.9, 0.1));
  near(least.distance, 0.1, 1e-8);
  [0, 1, 0].forEach((x, k) => near(least.direction[k], x, 1e-6));
  assert.ok(least.isExact && least.atLeast <= least.distance);
});
check("a pile has the contacts of each of its pairs, also after bodies moved and left", () => {
  const pile = sqmap.pile(), at = [[0, 0, 0], [0.1, 0, 1.9], [0.2, 0.1, 3.8], [9, 0, 0]];
  assert.deepEqual(at.map((p) => pile.add(cubeAt(...p))), [0, 1, 2, 3]);
  const pairsOf = (answer) => answer.pairs.map(({a, b}) => [a, b]);
  const first = pile.query();
  assert.deepEqual(pairsOf(first), [[0, 1], [1, 2]]);
  for (const {a, b, ...found} of first.pairs) assert.deepEqual(found, {...sqmap.contacts(cubeAt(...at[a]), cubeAt(...at[b])), status: found.status});
  assert.deepEqual(pairsOf(pile.query([shifted(20, 0, 0)])), [[1, 2]]);
  pile.remove(2);
  assert.deepEqual(pairsOf(pile.query([shifted(0, 0, 0), shifted(0, 0, 1.5)], {perRegion: 4})), [[0, 1]]);
  assert.deepEqual(pairsOf(pile.query([shifted(NaN, 0, 0)])), []);
  assert.notEqual(pile.query().status & 1, 0);
  assert.equal(pile.add(cubeAt(9, 0, 1.5)), 2);
  assert.deepEqual(pairsOf(pile.query([shifted(0, 0, 0)])), [[0, 1], [2, 3]]);
  pile.close();
});
refuses("an open probe", "E_MESH", /^triangles\[\d+\]$/, () => sqmap.probe(box(1).vertices, box(1).triangles.slice(1)));
refuses("a probe that is inside out", "E_MESH", /^triangles\[0\]$/, () => sqmap.probe(box(1).vertices, box(1).triangles.map((t) => t.reverse())));
refuses("a pair without a model", "E_HANDLE", /^a\.model$/, () => sqmap.pair({probe: cube.probe}, {probe: cube.probe}));
refuses("a pair with an option of contacts", "E_ARGUMENT", /^options\.perRegion$/, () => sqmap.pair(cube, cube, {perRegion: 4}));
refuses("a margin of a pair that is no number", "E_ARGUMENT", /^options\.margin$/, () => sqmap.pair(cube, cube, {margin: "1"}));
refuses("a body whose probe has points alone", "E_MISSING", /^b\.probe$/, () => sqmap.contacts(cube, {probe: sqmap.probe([[0, 0, 0]])}));

refuses("a mode that there is not", "E_ARGUMENT", /mode/, () => sqmap.session(model, {mode: "glued"}));
refuses("a session of nothing", "E_ARGUMENT", /model/, () => sqmap.session({}));
refuses("a stiffness below zero", "E_ARGUMENT", /stiffness/, () => sqmap.session(model, {stiffness: -1}));
refuses("an option that there is not", "E_ARGUMENT", /softness/, () => sqmap.session(model, {softness: 1}));
refuses("no mesh", "E_ARGUMENT", /vertices/, () => sqmap.bake({vertices: "x", triangles: []}));
refuses("an open mesh", "E_OPEN", /^edge vertices\[\d+\]-vertices\[\d+\]$/, () => {
  const {vertices, triangles} = box(6);
  sqmap.bake({vertices, triangles: triangles.slice(5)}, {repair: "none"});
});
refuses("a face beyond the vertices", "E_INDEX", /^triangles\[0\]$/, () => sqmap.bake({vertices: [[0, 0, 0]], triangles: [[0, 1, 9]]}));
refuses("bytes that are no model", "E_MODEL", /bytes|model/, () => sqmap.open(new Uint8Array(64)));
refuses("a model cut short", "E_MODEL", /bytes|model/, () => sqmap.open(model.toBytes().slice(0, 5000)));
refuses("no bytes", "E_ARGUMENT", /bytes/, () => sqmap.open("model"));
refuses("a wrong layer", "E_ARGUMENT", /layer/, () => model.query([[0, 0, 0]], {layer: 7}));
refuses("half a point", "E_ARGUMENT", /points/, () => model.query([1, 2, 3, 4]));
refuses("a pose of nine numbers", "E_ARGUMENT", /pose/, () => model.query([1, 2, 3], {pose: [1, 0, 0, 0, 1, 0, 0, 0, 1]}));
refuses("a pose that is not rigid", "E_ARGUMENT", /pose/, () => model.query([1, 2, 3], {pose: new Array(16).fill(2)}));
const nan = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, NaN, 0, 0, 0, 0, 1], origin = [[0, 0, 0]];
const probe = sqmap.probe(origin), closed = sqmap.probe(origin), other = await load();
closed.close();
refuses("a pose of NaN", "E_ARGUMENT", /^options\.pose\[10\]$/, () => model.query(origin, {pose: nan}));
refuses("a probe's pose of NaN", "E_ARGUMENT", /^options\.probePose\[10\]$/, () => model.probe(probe, {probePose: nan}));
refuses("a closed probe", "E_HANDLE", /^probe$/, () => model.probe(closed));
refuses("a probe of another library", "E_ARGUMENT", /^probe$/, () => model.probe(other.probe(origin)));
refuses("a probe without points", "E_ARGUMENT", /^points$/, () => sqmap.probe([]));
refuses("a point of a probe that is not finite", "E_ARGUMENT", /^points\[1\]$/, () => sqmap.probe([[0, 0, 0], [0, NaN, 0]]));
refuses("a target that is not finite", "E_ARGUMENT", /^targets\[0\]$/, () => sqmap.session(model).simulate([NaN, 0, 0]));
refuses("a limit of NaN", "E_ARGUMENT", /^options\.forceLimit$/, () => sqmap.session(model, {forceLimit: NaN}));
refuses("a projection that there is not", "E_ARGUMENT", /projection/, () => sqmap.bake(box(6), {projection: "mercator"}));
for (const wrong of [undefined, null, 5, "x", true, 1n, {}, [[1, 2]], [["a", "b", "c"]], new BigInt64Array(3)]) {
  const named = (element, action) => refuses(`${element} ${String(wrong)}`, "E_ARGUMENT", element, action);
  for (const call of ["query", "distances", "closestPoints"]) named(/^points/, () => model[call](wrong));
  named(/^points/, () => sqmap.probe(wrong));
  named(/^targets/, () => sqmap.session(model).simulate(wrong));
  named(/^probe$/, () => model.probe(wrong));
  named(/^model$/, () => sqmap.session(wrong));
  named(/^bytes$/, () => sqmap.open(wrong));
  named(/^bytes$/, () => sqmap.bakeFile("a.off", wrong));
  named(/^mesh$|^vertices/, () => sqmap.bake(wrong));
  named(/^vertices/, () => sqmap.bake({vertices: wrong, triangles: [[0, 1, 2]]}));
  named(/^triangles/, () => sqmap.bake({vertices: origin, triangles: wrong}));
  if (wrong !== undefined) {
    if (wrong !== null) named(/^options\.pose/, () => model.query(origin, {pose: wrong}));
    for (const option of wrong === 5 ? [] : ["margin", "tolerance"])
      named(RegExp(`^options\\.${option}$`), () => model.query(origin, {[option]: wrong}));
    if (wrong !== true) named(/^options\.smooth$/, () => model.query(origin, {smooth: wrong}));
    named(/^options\.layer$/, () => model.query(origin, {layer: wrong}));
    if (typeof wrong !== "object" || wrong === null) named(/^options$/, () => model.query(origin, wrong));
    for (const option of ["targetError", "band", "thickness", "repair", "projection", "source", "progress"])
      if (option !== "source" || wrong !== "x")
        if (wrong !== 5 || !["targetError", "band", "thickness"].includes(option))
          named(RegExp(`^options\\.${option}$`), () => sqmap.bake(box(1), {[option]: wrong}));
  }
}
check("a point that is not finite has no depth", () => {
  const {depth, status} = model.query([[0, NaN, 0]]);
  assert.ok(Number.isNaN(depth[0]) && (status[0] & 1) === 1);
});
check("an outer solid holds all sheets of a soup", () => {
  const {vertices, triangles} = box(6);
  const sheets = triangles.flatMap((t) => t.map((v) => vertices[v]));  // each triangle alone
  const loose = {vertices: sheets, triangles: triangles.map((_, i) => [3 * i, 3 * i + 1, 3 * i + 2])};
  const outer = sqmap.bake({...loose, triangles: loose.triangles.slice(1)}, {solid: "outer", gap: 0.005, maxParts: 4});
  const {distance} = outer.distances(sheets.slice(3));
  assert.ok(distance.every((d) => d < 0));
  assert.equal(outer.facts.cure, "wrapped");
  outer.close();
});
refuses("a gap wider than what can be closed", "E_ARGUMENT", /^options\.gap$/, () => sqmap.bake(box(6), {solid: "outer", gap: 0.3}));
refuses("a wrong solid", "E_ARGUMENT", /^options\.solid$/, () => sqmap.bake(box(6), {solid: "inner"}));
refuses("stopped", "E_CANCELLED", /./, () => sqmap.bake(box(6), {progress: () => false}));
check("an exception of progress goes through", () =>
  assert.throws(() => sqmap.bake(box(6), {progress: () => { throw new TypeError("mine"); }}), TypeError));
check("NaN is answered", () => assert.ok(Number.isNaN(model.distances([NaN, 0, 0]).distance[0])));
model.close();
refuses("a closed model", "E_HANDLE", /Model/, () => model.query([[0, 0, 0]]));
console.log(`package: ${checks} checks of sqmap ${sqmap.version}`);
