/dev/fd/3: line 20: compare: command not found
