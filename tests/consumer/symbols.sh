#!/bin/sh
# symbols.sh NM LIBRARY...: the external symbols of static libraries that are no copies of inline functions
# are in namespace wayfare. Others could be those of a user's program.
set -eu
nm=$1
shift
leaked=$("$nm" --defined-only --extern-only "$@" | awk 'NF == 3 && $2 !~ /[VWu]/ && $3 !~ /^_Z(T[VIS]|Thn[0-9]+_)?NK?7wayfare/ {print $3}')
if [ -n "$leaked" ]; then
  echo "outside namespace wayfare:"
  echo "$leaked" | c++filt
  exit 1
fi
"$nm" --defined-only --extern-only "$@" | grep -c ' T _ZN' | sed 's/$/ functions, all in namespace wayfare/'
