"""Particles: many of them, and tables about them."""
