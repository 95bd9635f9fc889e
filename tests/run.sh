#!/bin/sh
# Runs each argument, a test suite that ends with the line "N passed, N failed", and prints the sum as the last line.
# A suite that ends without that line, or with a non-zero exit code though it counts no failure, counts as one failure.
# A suite may add ", N skipped"; that is said on the line before the last.
count='^[0-9][0-9]* passed, [0-9][0-9]* failed\(, [0-9][0-9]* skipped\)*$'
passed=0 failed=0 skipped=0
log=$(mktemp) || exit 1
trap 'rm -f "$log" "$log.code"' EXIT
n=0
for suite in "$@"; do                 # side by side; each is shown when it is done, in the order given
    n=$((n + 1))
    { $suite > "$log.$n" 2>&1; echo $? > "$log.$n.code"; } &
done
wait
n=0
for suite in "$@"; do
    n=$((n + 1))
    mv "$log.$n" "$log"
    mv "$log.$n.code" "$log.code"
    grep -v "$count" "$log"           # the count is held back
    code=$(cat "$log.code")
    # shellcheck disable=SC2046   # the three numbers are wanted as words
    set_counts() { p=${1:-} f=${2:-} s=${3:-0}; }
    set_counts $(tail -n 1 "$log" | grep "$count" | tr -cs '0-9' ' ')
    if [ -z "$p" ]; then
        echo "FAIL: '$suite' ended early, with exit code $code"
        p=0 f=1
    elif [ "$f" = 0 ] && [ "$code" != 0 ]; then
        echo "FAIL: '$suite' counts no failure, but its exit code is $code"
        f=1
    fi
    passed=$((passed + p)) failed=$((failed + f)) skipped=$((skipped + s))
done
[ $skipped = 0 ] || echo "$skipped skipped"
echo "$passed passed, $failed failed"
[ $failed = 0 ]
