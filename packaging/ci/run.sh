#!/bin/sh
# Runs one command of canvass in a pipeline, and writes its result in every format.
#
#   CANVASS_COMMAND    test, fuzz, diagnose or "eds check"
#   CANVASS_ARGUMENTS  its arguments; quotes keep blanks together, and nothing in them is executed
#   CANVASS_REPORTS    the folder for the reports; canvass-reports if it is not set
#
# The exit status is that of canvass. In a workflow of GitHub the summary shows the result, and findings in descriptions
# are shown at their lines.
set -eu

command=${CANVASS_COMMAND:?expected test, fuzz, diagnose or eds check}
folder=${CANVASS_REPORTS:-canvass-reports}
words=$(printf '%s' "${CANVASS_ARGUMENTS:-}" | xargs -n 1 printf '%s\n')

# Each line is one argument, whatever it holds.
set -f
IFS='
'
set -- $words
unset IFS

case $command in
    test | diagnose) formats='json=json junit=xml html=html markdown=md' ;;
    fuzz) formats='json=json junit=xml html=html markdown=md sarif=sarif' ;;
    'eds check') formats='json=json junit=xml markdown=md sarif=sarif' ;;
    *)
        echo "run.sh: expected test, fuzz, diagnose or eds check, found $command" >&2
        exit 2
        ;;
esac

mkdir -p "$folder"
name=$(printf '%s' "$command" | tr ' ' '-')
for format in $formats; do
    set -- "$@" --report "${format%=*}=$folder/$name.${format#*=}"
done
if [ "$command" = 'eds check' ] && [ "${GITHUB_ACTIONS:-}" = true ]; then
    set -- "$@" --format github
fi

status=0
canvass $command "$@" || status=$?
if [ -n "${GITHUB_STEP_SUMMARY:-}" ] && [ -s "$folder/$name.md" ]; then
    cat "$folder/$name.md" >>"$GITHUB_STEP_SUMMARY"
fi
if [ -n "${GITHUB_OUTPUT:-}" ]; then
    printf 'status=%s\nreports=%s\n' "$status" "$folder" >>"$GITHUB_OUTPUT"
fi
exit $status
