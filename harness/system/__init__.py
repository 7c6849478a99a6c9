"""Child processes, file locks, and the memory limit of workers."""
