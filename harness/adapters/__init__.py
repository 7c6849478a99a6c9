"""Third-party libraries, one library a file."""
