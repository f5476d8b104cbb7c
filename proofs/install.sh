#!/bin/sh
# Tools that pip does not have. As root on Debian they are installed; otherwise what to type is said, and the proofs that
# lack a tool say that they were not run.
set -u
missing=""
command -v gcc >/dev/null || missing="$missing gcc libc6-dev"
command -v clang >/dev/null || missing="$missing clang"
command -v frama-c >/dev/null || missing="$missing frama-c-base"
command -v why3 >/dev/null || missing="$missing why3"
command -v cvc4 >/dev/null || missing="$missing cvc4"
command -v z3 >/dev/null || missing="$missing z3"
if command -v clang >/dev/null; then
    number=$(clang -dumpversion | cut -d. -f1)
    probe=$(mktemp -d)
    echo 'int LLVMFuzzerTestOneInput(const unsigned char *d, unsigned long n) { (void)d; (void)n; return 0; }' >"$probe/p.c"
    clang -fsanitize=fuzzer "$probe/p.c" -o "$probe/p" 2>/dev/null || missing="$missing libclang-rt-$number-dev"
    rm -r "$probe"
else
    missing="$missing libclang-rt-14-dev"
fi
[ -z "$missing" ] && exit 0
if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    echo "installing$missing"
    (apt-get update -qq && apt-get install -y -qq --no-install-recommends $missing) >/dev/null 2>&1 ||
        echo "could not be installed:$missing"
else
    echo "not installed; on Debian: apt-get install$missing"
fi
exit 0
