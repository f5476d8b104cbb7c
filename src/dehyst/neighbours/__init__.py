"""Models as other packages take them: `control` (python-control), `scikit` (scikit-learn), `benchmarks`.

Each module needs its package: ``pip install 'dehyst[control]'``, ``'dehyst[scikit]'``, ``'dehyst[benchmarks]'``.
"""
