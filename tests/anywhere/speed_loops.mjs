// The loops that speed.mjs measures, in Node and in a page. now: a clock in microseconds.

/** The best time of a probe on a model at layer 3, by poses that touch, as speed.c: the vertices of the tool, as large as the model. */
export function probes(sqmap, modelBytes, toolBytes, now) {
  const model = sqmap.open(modelBytes), tool = sqmap.open(toolBytes);
  const facts = model.facts, own = tool.facts;
  const probe = sqmap.probe(tool.mesh.vertices.map((x, i) => (x - own.centre[i % 3]) * facts.rMax / own.rMax + facts.centre[i % 3]));
  const rounds = 40, repeats = 500;
  let best = Infinity, all = 0, found = 0;
  for (let round = 0; round < rounds; ++round) {
    const begin = now();
    found = 0;
    for (let i = 0; i < repeats; ++i)
      found += model.probe(probe, {capacity: 0, probePose: [1, 0, 0, facts.rMax * 0.03 * (i % 25), 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}).found;
    const taken = now() - begin;
    best = Math.min(best, taken);
    all += taken;
  }
  return `${(best / repeats).toFixed(2)} us a probe of ${own.vertices} points, mean ${(all / rounds / repeats).toFixed(2)}, ${found} contacts`;
}

/** One bake. */
export function bake(sqmap, name, bytes, now) {
  const begin = now(), model = sqmap.bakeFile(name, bytes), taken = now() - begin;
  return `${(1e-6 * taken).toFixed(1)} s to bake ${model.facts.triangles} triangles`;
}
