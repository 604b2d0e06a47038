"""The book's own tools: figures, published numbers, notes and provenance; no physics."""
