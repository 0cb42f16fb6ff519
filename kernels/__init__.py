"""The OpenCL C sources, read by clrt.renderer."""
