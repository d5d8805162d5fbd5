vibrissa completions fish | source
