# From a mesh file to the signed distance of a point.
import sys

import sqmap

model = sqmap.bake(sys.argv[1])
print(f"{model.distances([[0, 0, 1.05]]).distance[0]:.2f}")  # in the mesh's frame and units
