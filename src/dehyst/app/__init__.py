"""The commands of the command line: each module runs one command and prints its result."""
