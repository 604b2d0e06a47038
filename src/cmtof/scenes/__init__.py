"""Where RGB-D comes from: files, folders, Hypersim, rooms from a seed, real captures."""

from cmtof.scenes.folders import frames_in, load_frame
from cmtof.scenes.frame import Frame, Frames, embedded_frames

__all__ = ["Frame", "Frames", "embedded_frames", "frames_in", "load_frame"]
