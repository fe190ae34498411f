// Drawing on a canvas, as the map and the section do.

/// The context of a canvas that shows wide by high pixels of the page, cleared. Units are pixels of the page.
export function cleared(canvas: HTMLCanvasElement, wide: number, high: number): CanvasRenderingContext2D {
  const scale = Math.min(devicePixelRatio, 2),
    width = Math.round(scale * wide),
    height = Math.round(scale * high),
    c = canvas.getContext('2d')!;
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
  }
  c.setTransform(scale, 0, 0, scale, 0, 0);
  c.clearRect(0, 0, wide, high);
  return c;
}

export function disc(c: CanvasRenderingContext2D, x: number, y: number, radius: number, colour: string): void {
  c.beginPath();
  c.arc(x, y, radius, 0, 2 * Math.PI);
  c.fillStyle = colour;
  c.fill();
}

/// A disc with a rim.
export function dot(
  c: CanvasRenderingContext2D,
  x: number,
  y: number,
  radius: number,
  colour: string,
  rim: string,
  width: number,
): void {
  disc(c, x, y, radius, colour);
  c.lineWidth = width;
  c.strokeStyle = rim;
  c.stroke();
}
