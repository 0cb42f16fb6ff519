"""Viewer: a scene in a browser or notebook, drawn anew when somebody moves it."""
