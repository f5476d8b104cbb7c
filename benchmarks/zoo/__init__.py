"""A zoo of rigs: actuators of physics that no model of dehyst contains, their logs, references and scores."""
