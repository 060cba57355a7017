"""Completion scripts of bash, zsh and fish.

click's own, but for words with `=` or `:` in them: bash ends its words there, the other two don't,
and click's scripts take what is offered behind `--backend=` for the whole word.
"""

from __future__ import annotations

import os
from typing import Any, Final

from click.shell_completion import (
    BashComplete,
    CompletionItem,
    FishComplete,
    ShellComplete,
    ZshComplete,
    add_completion_class,
    split_arg_string,
)

_BREAKS: Final = "=:"
"""Where bash ends a word (`COMP_WORDBREAKS`) that is one word to the program."""

_BASH: Final = """\
%(complete_func)s() {
    local IFS=$'\\n' type value answer line=${COMP_LINE:0:COMP_POINT}
    COMPREPLY=()
    for answer in $(env COMP_WORDS="$line" %(complete_var)s=bash_complete $1); do
        IFS=',' read -r type value <<< "$answer"
        case $type in
            dir) compopt -o dirnames ;;
            file) compopt -o default ;;
            plain) COMPREPLY+=("$value") ;;
        esac
    done
}
complete -o nosort -F %(complete_func)s %(prog_name)s
"""

_ZSH: Final = """\
#compdef %(prog_name)s
%(complete_func)s() {
    local -a plain described response
    local type key descr head
    (( ! $+commands[%(prog_name)s] )) && return 1
    response=("${(@f)$(env COMP_WORDS="${words[*]}" COMP_CWORD=$((CURRENT-1)) \
%(complete_var)s=zsh_complete %(prog_name)s)}")
    if [[ ${words[CURRENT]} == --*=* ]]; then
        head=${words[CURRENT]%%%%=*}=
        compset -p ${#head}
    fi
    for type key descr in ${response}; do
        case $type in
            dir) _path_files -/ ;;
            file) _path_files -f ;;
            plain) [[ $descr == _ ]] && plain+=("$key") || described+=("$key:$descr") ;;
        esac
    done
    (( $#described )) && _describe -V unsorted described
    (( $#plain )) && compadd -V unsorted -a plain
}
if [[ $zsh_eval_context[-1] == loadautofunc ]]; then
    %(complete_func)s "$@"
else
    compdef %(complete_func)s %(prog_name)s
fi
"""

_FISH: Final = """\
function %(complete_func)s
    set -l head (string match -r '^--[^=]+=' -- (commandline -ct))
    set -lx COMP_WORDS (commandline -cp | string collect)
    set -lx COMP_CWORD (commandline -ct | string collect)
    set -lx %(complete_var)s fish_complete
    for answer in (%(prog_name)s)
        set -l parts (string split -m 1 , -- $answer)
        switch $parts[1]
            case dir
                for path in (__fish_complete_directories $parts[2])
                    printf '%%s\\n' "$head$path"
                end
            case file
                for path in (__fish_complete_path $parts[2])
                    printf '%%s\\n' "$head$path"
                end
            case plain
                printf '%%s\\n' "$head$parts[2]"
        end
    end
end
complete --no-files --command %(prog_name)s --arguments "(%(complete_func)s)"
"""


class _Bash(BashComplete):
    """Reads the line as it is typed; what is offered begins where bash's own word does."""

    source_template = _BASH

    def get_completion_args(self) -> tuple[list[str], str]:
        line = os.environ["COMP_WORDS"]
        words = split_arg_string(line)
        if line[-1:].isspace():
            words.append("")
        return words[1:-1], words[-1] if len(words) > 1 else ""

    def get_completions(self, args: list[str], incomplete: str) -> list[CompletionItem]:
        """Values without the part of the word that bash takes for words of its own."""
        items = super().get_completions(args, incomplete)
        typed = incomplete.partition("=")[2] if incomplete.startswith("--") else incomplete
        cut = max(typed.rfind(mark) for mark in _BREAKS) + 1
        return [CompletionItem(i.value[cut:], i.type) if i.value else i for i in items]


class _Zsh(ZshComplete):
    source_template = _ZSH


class _Fish(FishComplete):
    source_template = _FISH


_CLASSES: Final[dict[str, type[ShellComplete]]] = {"bash": _Bash, "zsh": _Zsh, "fish": _Fish}


def register() -> None:
    """Have click ask these for scripts and answers."""
    for name, kind in _CLASSES.items():
        add_completion_class(kind, name)


def completer(command: Any, shell: str) -> ShellComplete:
    """What answers a shell that asks how the words of a click command go on."""
    return _CLASSES[shell](command, {}, "stlc", "_STLC_COMPLETE")


def script(command: Any, shell: str) -> str:
    """What a shell reads to complete the words of a click command."""
    kind = completer(command, shell)
    return str(kind.source_template % kind.source_vars())
