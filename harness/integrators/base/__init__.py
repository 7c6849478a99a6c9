"""What several families of integrators share."""
