"""What is on the screen: a scene in a browser, drawn anew when somebody moves it."""
