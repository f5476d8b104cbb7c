"""FMUs: the C export behind the functions of FMI 2.0 and 3.0."""
