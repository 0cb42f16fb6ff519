"""What is drawn over a picture: colour bars, legends, cells."""
