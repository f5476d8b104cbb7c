"""One file a command: call one function, print what it found."""
