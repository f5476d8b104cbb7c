"""The program of the direct inverse: its data, its terms, and their selection."""
