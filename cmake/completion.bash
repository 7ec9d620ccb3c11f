# Completion of pavescape for bash: asks the program for its commands, options and the words that an option takes.
_pavescape() {
    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} command=${COMP_WORDS[1]} program=${COMP_WORDS[0]}
    if [ "$COMP_CWORD" -eq 1 ]; then
        local commands
        commands=$("$program" --help 2>/dev/null | sed -n '/^Subcommands:/,$ s/^  \([a-z]\+\) .*/\1/p')
        mapfile -t COMPREPLY < <(compgen -W "$commands --help --version" -- "$word")
        return
    fi
    if [[ $before == --* && $word != -* ]]; then
        local line words
        line=$("$program" "$command" --help 2>/dev/null | grep -m 1 -e "^  $before ")
        words=$(sed -n 's/^[^{]*{\([^}]*\)}.*/\1/p' <<< "$line" | sed 's/->[^,]*//g') # {one,other} or {one->0,other->1}
        if [ -n "$words" ]; then # it takes one of these
            mapfile -t COMPREPLY < <(compgen -W "${words//,/ }" -- "$word")
            return
        elif [[ $before == --out ]]; then
            mapfile -t COMPREPLY < <(compgen -d -- "$word")
            return
        elif [[ $before == --from || $before == --study || $before == --columns || $before == --layers || $line =~ ^\ \ --[a-z-]+\ [A-Z\|]*FILE ]]; then
            mapfile -t COMPREPLY < <(compgen -f -- "$word")
            return
        elif [[ $line =~ ^\ \ --[a-z-]+\ [A-Z]+ ]]; then # it takes a number or a text
            COMPREPLY=()
            return
        fi
    fi
    if [[ $word == -* ]]; then
        local options
        options=$("$program" "$command" --help 2>/dev/null | grep -o '^  \(-h,\)\?--[a-z-]\+' | sed 's/^ *\(-h,\)\?//')
        mapfile -t COMPREPLY < <(compgen -W "$options" -- "$word")
    else
        case $command in
            plot)
                if [ "$COMP_CWORD" -eq 2 ]; then
                    mapfile -t COMPREPLY < <(compgen -d -- "$word")
                else
                    local figures
                    figures=$("$program" plot --help 2>/dev/null | sed -n 's/^  FIGURE TEXT \.\.\. *\([^(]*\)(.*/\1/p')
                    mapfile -t COMPREPLY < <(compgen -W "${figures//,/ }" -- "$word")
                fi ;;
            report | export | rerun | merge) mapfile -t COMPREPLY < <(compgen -d -- "$word") ;;
            survey | road | slab | noise) mapfile -t COMPREPLY < <(compgen -f -- "$word") ;;
            *) mapfile -t COMPREPLY < <(compgen -f -X '!*.toml' -- "$word"; compgen -d -- "$word") ;;
        esac
    fi
}
complete -o filenames -F _pavescape pavescape
