# Asks the program at the first completion, so that it always fits.
eval "$(vibrissa-robot completions bash)"
