"""Motion: pictures one after the other, on one machine or many."""
