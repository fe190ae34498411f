# Which grasps of a mug hold its handle and touch nothing else.
import numpy as np
import sqmap


def tube(middle, radius, segments=24):
    """A closed tube about a line of points that lies in the plane y = 0."""
    along = np.gradient(middle, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    angle = np.linspace(0, 2 * np.pi, segments, endpoint=False)
    side = np.cross([0, 1, 0], along)
    rings = middle[:, None] + radius * (np.cos(angle)[:, None] * side[:, None] + np.sin(angle)[:, None] * np.array([0, 1, 0]))
    return closed(rings, middle[0], middle[-1])


def closed(rings, first, last):
    """The surface through rings (n, m, 3) of points, with a fan to one point at either end."""
    n, m, _ = rings.shape
    i, j = np.mgrid[:n - 1, :m]
    a, b, c, d = i * m + j, i * m + (j + 1) % m, (i + 1) * m + j, (i + 1) * m + (j + 1) % m
    k, next_k = np.arange(m), (np.arange(m) + 1) % m
    top = (n - 1) * m
    triangles = [np.stack(t, -1).reshape(-1, 3) for t in ((a, b, d), (a, d, c), (np.full(m, n * m), next_k, k),
                                                          (np.full(m, n * m + 1), top + k, top + next_k))]
    return np.concatenate([rings.reshape(-1, 3), [first, last]]), np.concatenate(triangles)


def mug():
    """A cup 80 mm wide, 100 mm high, and a handle that ends in its wall; metres."""
    profile = np.array([(0.02, 0), (0.036, 0), (0.04, 0.004), (0.04, 0.03), (0.04, 0.07), (0.04, 0.1), (0.036, 0.1), (0.036, 0.07),
                        (0.036, 0.03), (0.036, 0.006), (0.02, 0.006)])
    angle = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    rings = np.stack([profile[:, :1] * np.cos(angle), profile[:, :1] * np.sin(angle), np.repeat(profile[:, 1:], 64, 1)], -1)
    cup, cup_triangles = closed(rings, (0, 0, 0), (0, 0, 0.006))
    arc = np.linspace(-np.pi / 2, np.pi / 2, 33)
    handle, handle_triangles = tube(np.stack([0.038 + 0.03 * np.cos(arc), 0 * arc, 0.05 + 0.028 * np.sin(arc)], -1), 0.005)
    return np.concatenate([cup, handle]), np.concatenate([cup_triangles, handle_triangles + len(cup)])


model = sqmap.bake(mug(), unit="m")
named = model.named_parts  # of each part
handle = named[model.distances([[0.068, 0, 0.05]]).part[0]]

# A gripper open by 30 mm: each finger is a bar of 10 x 8 x 40 mm, its pad the inner side at the tip. It closes along y.
bar = np.stack(np.meshgrid(np.linspace(-0.005, 0.005, 5), [0, 0.004, 0.008], np.linspace(-0.04, 0, 12), indexing="ij"), -1).reshape(-1, 3)
fingers = [bar * [1, s, 1] + [0, 0.015 * s, 0] for s in (-1, 1)]
pads = [f[(abs(f[:, 1]) < 0.016) & (f[:, 2] > -0.01)] for f in fingers]


def reaching(tip, finger, closing):
    """The pose of the gripper whose fingers point along one direction to the tip and close along the other."""
    pose = np.eye(4)
    pose[:3, :3] = np.stack([np.cross(closing, finger), closing, finger], -1)
    pose[:3, 3] = tip
    return pose


# From twelve sides at several heights and depths, and from above over the rim.
poses, down = [], np.array([0, 0, -1.0])
for turn in np.arange(12) * np.pi / 6:
    out, side = np.array([np.cos(turn), np.sin(turn), 0]), np.array([-np.sin(turn), np.cos(turn), 0])
    for depth in (0.035, 0.06, 0.068, 0.08):
        poses += [reaching(depth * out + [0, 0, height], -out, side) for height in (0.03, 0.05, 0.07)]
    poses.append(reaching(0.038 * out + [0, 0, 0.085], down, out))
poses = np.array(poses)

free = np.all([model.clearance(f, poses, stop_below=0).distance > 0 for f in fingers], axis=0)
near = [model.clearance(p, poses) for p in pads]
stroke = np.all([n.distance < 0.015 for n in near], axis=0)
on_handle = np.all([named[n.part] == handle for n in near], axis=0)
between = np.einsum("ij,ij->i", near[0].gradient[:, :3], near[1].gradient[:, :3]) < 0  # the pads meet opposite sides

print(f"{len(poses)} grasps: {np.sum(free)} free, {np.sum(free & stroke)} within the stroke, "
      f"{np.sum(free & stroke & on_handle & between)} of the handle")
