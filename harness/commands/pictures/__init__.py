"""Pictures of motions and of failures, as the commands draw them."""
