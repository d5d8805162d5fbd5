vibrissa-robot completions fish | source
