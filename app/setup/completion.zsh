#compdef gpvc
# zsh: completes gpvc's commands and options, as its help lists them.
if (( CURRENT == 2 )); then
  compadd help ${(f)"$(gpvc help 2>/dev/null | sed -n 's/^  \([a-z][a-z]*\)  .*/\1/p')"}
elif [[ $PREFIX == -* ]]; then
  compadd -- ${(f)"$(gpvc help ${words[2]} 2>/dev/null | grep -oE '^ +(-[a-z],? ?)?--[a-z-]+' | grep -oE -- '--[a-z-]+')"}
else
  _files
fi
