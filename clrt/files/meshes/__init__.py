"""Meshes of files and of other libraries' objects."""
