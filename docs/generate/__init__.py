"""What `docs/build.py` makes: reference pages, shown outputs, figures."""
