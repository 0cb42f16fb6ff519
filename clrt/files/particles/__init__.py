"""Files of particles, and objects that hold some: to Particles, one frame at a time."""
