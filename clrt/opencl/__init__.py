"""OpenCL, and nothing of scenes: devices, PoCL, programs, and a kernel over a film."""
