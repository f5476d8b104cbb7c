#!/bin/sh
# Mutation testing of the core: the bits of the core are the tests (tests/core_bits.c). Results in proofs/mutants_core.json.
cd "$(dirname "$0")/.." || exit 2
exec "${PYTHON:-python3}" proofs/mutants.py proofs/mutants_core.json --files core/*.c --count "${COUNT:-400}" \
    --build 'mkdir -p build; for f in core/*.c tests/core_bits.c; do o=build/$(basename $f .c).o
             [ $o -nt $f ] || gcc -std=c11 -O1 -ffp-contract=off -Icore -c $f -o $o || exit 1; done
             gcc build/*.o -o build/core_bits' \
    --artefact build/core_bits --test 'build/core_bits > build/found.txt && cmp build/found.txt tests/core_bits.txt' "$@"
