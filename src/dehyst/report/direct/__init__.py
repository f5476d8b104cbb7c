"""The report of a direct inverse: figures, lights, tables, next steps."""
