"""What a compensator does on a joint that is not as it was identified, and models and laws side by side."""
