#!/usr/bin/env bash
# What a library says names no option or command of the command line, which its caller may not have: advice is a Cure
# (io/error.h), and app/cli/cures.cpp alone knows its words. Looks at string literals.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
commands='texture|tileset|ortho|tiles|unit|plan|visibility|evaluate|compare|label|inspect|photos|coverage|view|convert|synth'
# plan_text.cpp writes shell scripts that call the program; "compare --summarize" is the name of a result in run.json.
named=$(grep -rnE --include='*.cpp' --include='*.h' "\"[^\"]*(--[a-z]|gpvc ($commands)\b)" io visibility labeling atlas app |
  grep -vE '^app/(cli|texrecon)/|^app/tiles/plan_text\.cpp:|\{"compare --summarize", \{"summary' || true)
if [ -n "$named" ]; then
  echo "library_sentences.sh: names what only the command line knows:" >&2
  echo "$named" >&2
  exit 1
fi
