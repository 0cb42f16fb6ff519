"""Film: a picture after it is traced."""
