"""Stereo supervision (Sec. 6.4): two cameras watch the laser spot and say which wrap it lies in.

From left to right: a board calibrates both cameras (`calibrate`), spots are found (`find_spot`) and
triangulated (`triangulate`), they locate the scanner (`locate_scanner`), and their ranges become
labels (`truth_from_spots`). The cameras are simulated (`simulated_rig`, `view_scene`, `record`);
`pseudo_truth` does all of it for a frame.
"""

from cmtof.stereo.board import Board, board_image, find_corners
from cmtof.stereo.calibration import Calibration, calibrate, simulated_views
from cmtof.stereo.camera import INTRINSICS, PinholeCamera
from cmtof.stereo.pose import Pose
from cmtof.stereo.rig import PARAMETERS, StereoRig, simulated_rig
from cmtof.stereo.scanner import locate_scanner
from cmtof.stereo.sensor import Sensor
from cmtof.stereo.spot import Spots, Status, find_spot, fit_spots, spot_bound
from cmtof.stereo.supervision import PseudoTruth, Reason, pseudo_truth, ranges, truth_from_spots
from cmtof.stereo.triangulation import Triangulated, triangulate
from cmtof.stereo.views import Lighting, Scene, record, view_scene, visible_from

__all__ = [
    "INTRINSICS",
    "PARAMETERS",
    "Board",
    "Calibration",
    "Lighting",
    "PinholeCamera",
    "Pose",
    "PseudoTruth",
    "Reason",
    "Scene",
    "Sensor",
    "Spots",
    "Status",
    "StereoRig",
    "Triangulated",
    "board_image",
    "calibrate",
    "find_corners",
    "find_spot",
    "fit_spots",
    "locate_scanner",
    "pseudo_truth",
    "ranges",
    "record",
    "simulated_rig",
    "simulated_views",
    "spot_bound",
    "triangulate",
    "truth_from_spots",
    "view_scene",
    "visible_from",
]
