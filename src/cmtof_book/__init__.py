"""The book's own tools: figures, published numbers, notes and provenance; no physics."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
"""Folder of the checkout."""
