"""Case files, series files, sweep files: tables and models, from there to problems, methods and solutions, and back."""
