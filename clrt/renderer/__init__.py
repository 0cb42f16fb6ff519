"""Renderer: from a scene and a size to light."""
