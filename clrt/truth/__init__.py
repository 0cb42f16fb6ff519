"""Truth: the float64 pictures that the kernels are held against."""
