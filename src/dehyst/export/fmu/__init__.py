"""FMUs: the exported C code with the functions of FMI 2.0 and 3.0."""
