"""Identification: data -> model, with what the data can and cannot tell."""
