"""Cases: closed chains of rigid bodies."""
