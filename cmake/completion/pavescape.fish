# Completion of pavescape for fish: the program says what may follow.
function __pavescape_complete
    set -l words (commandline -opc)
    set -l word (commandline -ct)
    for line in ($words[1] --complete $words[2..-1] "$word" 2>/dev/null)
        switch $line
            case ':files' ':studies'
                __fish_complete_path "$word"
            case ':folders'
                __fish_complete_directories "$word" ''
            case '*'
                echo $line
        end
    end
end
complete -c pavescape -f -a '(__pavescape_complete)'
