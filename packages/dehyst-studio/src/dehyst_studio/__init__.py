"""dehyst in a browser, and beside a running machine: the page, the studio, watch."""
