#!/bin/sh
# run.sh PAGE.md FOLDER SOURCE BUILD [DATA]: follows a tutorial in the empty FOLDER, as a reader does
# after docs/tutorials/README.md. Of the page it takes, in order:
#   ```sh             commands, in one shell; ```sh recordings: where there is DATA
#   ```text [N%]      the output of the commands before; numbers to N percent (2 by default): expect.awk
#   ```LANGUAGE FILE  a file
# Other blocks are not run. BUILD stands for SOURCE/build.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
page=$1
rm -rf "$2"
mkdir -p "$2/.run"
folder=$(cd "$2" && pwd)
mkdir "$folder/.run/wayfare"
ln -s "$4" "$folder/.run/wayfare/build"
ln -s "$3/examples" "$folder/.run/wayfare/examples"
export WAYFARE="$folder/.run/wayfare" PATH="$4/bin:$PATH" DATA="${5:-}" LC_ALL=C
[ -n "$DATA" ] && recordings=1 || recordings=0
awk -v recordings=$recordings -f "$here/script.awk" "$page" >"$folder/.run/page"

begin() {
  line=$1
  exec >"$folder/.run/output" 2>"$folder/.run/errors"
}
end() {
  exec >&3 2>&4
  line=
}
expect() {
  cat >"$folder/.run/shown"
  awk -v tolerance="${2%\%}" -f "$here/expect.awk" "$folder/.run/shown" "$folder/.run/output" && return
  echo "$page:$1: the output is another; it was"
  cat "$folder/.run/output"
  exit 1
}
left() {
  status=$?
  [ -n "$line" ] || exit $status
  end_of=$line
  end
  echo "$page:$end_of: a command failed"
  cat "$folder/.run/output" "$folder/.run/errors"
  exit 1
}
exec 3>&1 4>&2
line=
trap left EXIT
cd "$folder"
. ./.run/page
echo "$page: $(grep -c '^begin [0-9]' .run/page) blocks of commands, $(grep -c '^expect [0-9]' .run/page) of output"
