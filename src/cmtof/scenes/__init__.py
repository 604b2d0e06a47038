"""Where RGB-D comes from: files, the embedded frames, real captures, analytic solids."""

from cmtof.scenes.rgbd import Frame, embedded_frames, load_frame

__all__ = ["Frame", "embedded_frames", "load_frame"]
