"""Many cases from one file: axes and samples over a base case, solved by many processes, told in one table."""
