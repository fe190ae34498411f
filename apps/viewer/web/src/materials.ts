// Touch and sound of surface materials. Modes: ratios to the lowest frequency of a free bar or a plate.
export interface Material {
  name: string;
  stiffness: number;
  damping: number;
  friction: number;
  texture: number; ///< N/m, N s/m, Coulomb's coefficient, m
  /// Sound. speed: of a wave, m/s; divided by the object's size it is the frequency of the lowest mode, which dies away in `periods`
  /// periods; higher modes die sooner. loud: 0 to 1; rustle: loudness of sliding, 0 to 1; pitch: of the rustle, Hz.
  speed: number;
  periods: number;
  loud: number;
  rustle: number;
  pitch: number;
}
export const MODES = [1, 2.76, 5.4, 8.93];
export const PLAIN: Material = {
  name: 'Plain',
  stiffness: 500,
  damping: 0.3,
  friction: 0.3,
  texture: 0,
  speed: 60,
  periods: 12,
  loud: 0.5,
  rustle: 0.5,
  pitch: 1400,
};
export const MATERIALS: Record<string, Material> = {
  plain: PLAIN,
  wood: {
    name: 'Wood',
    stiffness: 900,
    damping: 0.4,
    friction: 0.35,
    texture: 0.0001,
    speed: 85,
    periods: 14,
    loud: 0.9,
    rustle: 0.6,
    pitch: 1100,
  },
  stone: {
    name: 'Stone',
    stiffness: 1500,
    damping: 0.2,
    friction: 0.55,
    texture: 0.0002,
    speed: 260,
    periods: 26,
    loud: 0.9,
    rustle: 0.9,
    pitch: 2600,
  },
  rubber: {
    name: 'Rubber',
    stiffness: 350,
    damping: 1,
    friction: 0.9,
    texture: 0,
    speed: 22,
    periods: 3,
    loud: 0.7,
    rustle: 0.35,
    pitch: 500,
  },
  skin: {
    name: 'Skin',
    stiffness: 200,
    damping: 0.8,
    friction: 0.45,
    texture: 0,
    speed: 14,
    periods: 2,
    loud: 0.5,
    rustle: 0.3,
    pitch: 900,
  },
  cloth: {
    name: 'Cloth',
    stiffness: 150,
    damping: 0.5,
    friction: 0.5,
    texture: 0.0003,
    speed: 9,
    periods: 1.5,
    loud: 0.35,
    rustle: 1,
    pitch: 3200,
  },
};
