#!/usr/bin/env bash
# clean_up.sh SCRATCH: waits until its standard input ends, which a script holds open as long as it lives, and takes away what
# the script has left: the processes in SCRATCH/group, what SCRATCH/files lists, and SCRATCH. Started by setup.sh.
scratch=$1

cat > /dev/null

if [ -s "$scratch/group" ]; then
  read -r group < "$scratch/group"
  kill -TERM -- "-$group" 2> /dev/null
  for _ in 1 2 3 4 5 6 7 8 9 10; do  # as long as it takes to stop in order
    kill -0 -- "-$group" 2> /dev/null || break
    sleep 0.5
  done
  kill -KILL -- "-$group" 2> /dev/null
fi
if [ -s "$scratch/files" ]; then
  while read -r file; do
    rm -f -- "$file" 2> /dev/null || sudo -n rm -f -- "$file"
  done < "$scratch/files"
fi
rm -rf -- "$scratch"
