# Completion of pavescape for bash: asks the program for its commands and options.
_pavescape() {
    local word=${COMP_WORDS[COMP_CWORD]} command=${COMP_WORDS[1]} program=${COMP_WORDS[0]}
    if [ "$COMP_CWORD" -eq 1 ]; then
        local commands
        commands=$("$program" --help 2>/dev/null | sed -n '/^Subcommands:/,$ s/^  \([a-z]\+\) .*/\1/p')
        mapfile -t COMPREPLY < <(compgen -W "$commands --help --version" -- "$word")
    elif [[ $word == -* ]]; then
        local options
        options=$("$program" "$command" --help 2>/dev/null | grep -o '^  \(-h,\)\?--[a-z-]\+' | sed 's/^ *\(-h,\)\?//')
        mapfile -t COMPREPLY < <(compgen -W "$options" -- "$word")
    else
        case $command in
            report | export | rerun) mapfile -t COMPREPLY < <(compgen -d -- "$word") ;;
            survey | road) mapfile -t COMPREPLY < <(compgen -f -- "$word") ;;
            *) mapfile -t COMPREPLY < <(compgen -f -X '!*.toml' -- "$word"; compgen -d -- "$word") ;;
        esac
    fi
}
complete -o filenames -F _pavescape pavescape
