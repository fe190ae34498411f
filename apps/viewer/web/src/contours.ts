// Level sets of a function on a square grid, by marching squares.

/// Ends of segments, four numbers each: x, y from 0 to 1, y along the rows. values: side by side numbers, x fastest.
export function levelSet(values: Float32Array, side: number, level: number): number[] {
  const out: number[] = [], step = 1 / (side - 1);
  // F grows with high powers: on its logarithm the crossing between two points is nearer to the truth.
  const v = Float32Array.from(values, (x) => Math.log(Math.max(x, 1e-12) / level));
  for (let y = 0; y + 1 < side; ++y)
    for (let x = 0; x + 1 < side; ++x) {
      const i = y * side + x, corners: [number, number, number][] = [[x, y, v[i]], [x + 1, y, v[i + 1]], [x + 1, y + 1, v[i + side + 1]], [x, y + 1, v[i + side]]], ends: number[] = [];
      for (let k = 0; k < 4; ++k) {
        const [ax, ay, a] = corners[k], [bx, by, b] = corners[(k + 1) % 4];
        if (a < 0 === b < 0) continue;
        const t = a / (a - b);
        ends.push(step * (ax + t * (bx - ax)), step * (ay + t * (by - ay)));
      }
      // Of a saddle's four ends the neighbours belong together.
      for (let k = 0; k + 3 < ends.length; k += 4) out.push(...ends.slice(k, k + 4));
    }
  return out;
}
