#!/bin/sh
# Mutation testing of the core: its claims (tests/support/core_claims.c, under the sanitizers) and its bits (tests/support/core_bits.c)
# are the tests. Results in proofs/mutants_core.json.
cd "$(dirname "$0")/.." || exit 2
exec "${PYTHON:-python3}" proofs/mutants.py proofs/mutants_core.json --files packages/dehyst/core/*.c --count "${COUNT:-400}" \
    --build 'mkdir -p build/p build/s; for f in packages/dehyst/core/*.c; do o=$(basename $f .c).o
             [ build/p/$o -nt $f ] || gcc -std=c11 -O1 -ffp-contract=off -Icore -c $f -o build/p/$o || exit 1
             [ build/s/$o -nt $f ] || gcc -std=c11 -O1 -fsanitize=address,undefined -fno-sanitize-recover=all -Icore -c $f -o build/s/$o || exit 1; done
             gcc -std=c11 -O1 -ffp-contract=off -Icore tests/support/core_bits.c build/p/*.o -o build/core_bits &&
             gcc -std=c11 -O1 -fsanitize=address,undefined -Icore tests/support/core_claims.c build/s/*.o -lm -o build/core_claims' \
    --artefact build/core_bits \
    --test 'build/core_claims && build/core_bits > build/found.txt && cmp build/found.txt tests/support/core_bits.txt' "$@"
