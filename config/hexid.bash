# bash completion for hexid: subcommands, options and what they take, as the program's own help has them.
_hexid() {
    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} name=${COMP_WORDS[1]}
    COMPREPLY=()
    if ((COMP_CWORD == 1)); then
        mapfile -t COMPREPLY < <(compgen -W "--help --version $("$1" --help 2>/dev/null | sed -n 's/^  hexid \([a-z]\{1,\}\) .*/\1/p')" -- "$word")
        return
    fi
    case $name:$before in
        *:--rt) mapfile -t COMPREPLY < <(compgen -W "require try off" -- "$word") ;;
        *:--replay) mapfile -t COMPREPLY < <(compgen -W "closed-loop motion" -- "$word") ;;
        *:--set) mapfile -t COMPREPLY < <(compgen -S = -W "$("$1" doctor --keys 2>/dev/null | sed -n 's/^| `\([a-z0-9_.]*\)` |.*/\1/p')" -- "$word")
            compopt -o nospace ;;
        command:--machine) mapfile -t COMPREPLY < <(compgen -W "$(for socket in "${HEXID_RUNTIME_DIR:-/run/hexid}"/*.stop "${XDG_RUNTIME_DIR:-/nowhere}"/hexid/*.stop; do
            [ ! -S "$socket" ] || basename "$socket" .stop; done)" -- "$word") ;;
        command:command) mapfile -t COMPREPLY < <(compgen -W "engage start stop park reset" -- "$word") ;;
        effects:effects) mapfile -t COMPREPLY < <(compgen -W "$("$1" effects 2>/dev/null | sed -n 's/^\([a-z_]\{1,\}\).*/\1/p')" -- "$word") ;;
        *)
            if [[ $word == -* ]]; then
                mapfile -t COMPREPLY < <(compgen -W "--help $("$1" "$name" --help 2>/dev/null | sed -n 's/^  \(--*[a-z-]\{1,\}\).*/\1/p')" -- "$word")
            else
                compopt -o default
            fi ;;
    esac
}
complete -F _hexid hexid
