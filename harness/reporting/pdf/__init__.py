"""The accuracy report of one integrator, a PDF of 6 to 10 pages."""
