"""The published report: its parts, their commands, and its assembly."""
