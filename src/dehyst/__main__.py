"""``python -m dehyst``: the command line."""

from dehyst.cli import main

if __name__ == "__main__":
    main()
