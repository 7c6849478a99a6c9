"""The parts of the page that a reader sees first, and the tables and pictures of single cases and integrators."""
