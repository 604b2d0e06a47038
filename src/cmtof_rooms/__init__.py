"""Furnished rooms from a seed: solids, a shell, furniture from presets, light by Embree."""
