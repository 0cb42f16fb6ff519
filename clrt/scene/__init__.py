"""Scene: everything that a picture depends on."""
