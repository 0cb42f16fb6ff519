"""Files: bytes to values and back: scenes, pictures, videos."""
