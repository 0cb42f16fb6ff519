"""Pack: a scene as what its program is compiled for, and as the flat buffers that the kernel reads.

What does not depend on the camera is packed once (world), the rest for each picture (arguments).
"""
