"""Case files, solution files, sweep files: from there to problems, methods and solutions, and back."""
