"""Where RGB-D comes from: files, folders, Hypersim, rooms from a seed, real captures."""

from cmtof.scenes.rgbd import Frame, embedded_frames, load_frame

__all__ = ["Frame", "embedded_frames", "load_frame"]
