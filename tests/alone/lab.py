"""What the extra `lab` promises: the objects that are scanned, and the stereo rig beside them."""

import numpy as np

from cmtof_lab.objects import object_mesh
from cmtof_lab.stereo import simulated_rig

points = np.array([[0.0, 0.0, 1.0], [0.1, -0.1, 1.2]])
rig = simulated_rig()
np.testing.assert_allclose(rig.triangulate(rig.project(points)), points, atol=1e-6)
assert object_mesh("bust").area > 0.1  # m²
