"""Logs and model files: bar and degrees stop here."""
