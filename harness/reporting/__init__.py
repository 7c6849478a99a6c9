"""Tables, findings, figures and the page."""
