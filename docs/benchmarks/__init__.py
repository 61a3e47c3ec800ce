"""How long the commands that users feel take, release by release."""
