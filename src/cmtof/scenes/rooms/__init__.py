"""Rooms from a seed: built from parameters over trimesh, traced with Embree."""
